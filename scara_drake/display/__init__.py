"""What the operator sees in Meshcat, and the drawing of a Diagram."""
