"""Joint controllers: a pure law under each thin LeafSystem."""
