"""The operator's station: a page in any browser, and the process that serves it."""
