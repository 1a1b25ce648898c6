"""What real drives and sensors add to the plant."""
