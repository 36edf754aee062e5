"""From the feedback of one repetition to the feedforward of the next [x_fb_i-1]."""
