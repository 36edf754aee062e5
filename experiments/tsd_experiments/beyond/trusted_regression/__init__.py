"""Whether predictions of the regression can be trusted, from few entries and wrong ones too."""
