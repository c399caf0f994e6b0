"""What a run says about itself: whether its numbers can be trusted, and why not."""
