"""The browser page of a run, a log or a study: one file that needs no network."""
