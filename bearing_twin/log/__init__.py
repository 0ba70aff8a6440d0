"""Topics of a run as messages, and logs of them as MCAP files: no ROS is needed.

* `stream`: the topics of a scene (`topics`), their table in words, and their messages (`MessageStream`).
* `cdr`: types of messages and their bytes.
* `run_log`: `write_log` and `LogWriter` write runs, `read_log` reads them; `study_log`: `StudyLog`, `read_study`.
* `raw_log`: `RawLogWriter` writes messages of any topics, `recover` copies what is whole of a damaged log.
* `bag`: `LogReader` and `raw_messages` read any log by time.
* `export`: CSV, Parquet, NetCDF; `layouts`: other viewers.
* `mcap_read`, `mcap_write`: the file format, for this room alone.
"""
