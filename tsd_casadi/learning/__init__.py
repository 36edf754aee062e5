"""The update [x_fb_i-1]: from the feedback of one repetition to the feedforward of the next."""
