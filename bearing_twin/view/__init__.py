"""The page of a run, a log or a study for the browser: one file that needs no network.

* `run_page`: `run_document`, `log_document`; `live_page`: `live_page` of a run that goes on.
* `study_page`: `study_document`; `study_picture`: `plot_study`.
* `page`: `write_page` puts a document into the page, `write_gif` animates it; outputs thinned and packed.
* `page_server`: `PageServer` serves the page of a run that goes on, its events and its commands.
* `tables`: figures as rows in engineering units.
"""
