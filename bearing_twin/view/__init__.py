"""The page of a run, a log or a study for the browser: one file that needs no network.

* `run_page`: the document of a run or a log (`run_document`, `log_document`).
* `study_page`: the document of a study, `study_document`.
* `study_picture`: the picture of a study.
* `live_page`: the page of a run that goes on, and its frames.
* `page`: a document as a page or as an animation, and the browser that draws it.
* `page_server`: the page of a run that goes on as it is served, its events and its commands.
* `tables`: figures as rows in engineering units.
"""
