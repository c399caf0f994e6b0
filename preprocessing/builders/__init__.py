"""Files that reduced models are made from, and all steps from such a file to the model."""
