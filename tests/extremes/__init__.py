"""What the toolkit does at the extremes of its numbers, each against a closed form, a limit or an invariance."""
