"""Topics of a run as messages, and logs of them as MCAP files: no ROS is needed.

* `stream`: the topic table of a scene (`topics`) and its messages (`MessageStream`); `topic_table`: as text.
* `cdr`, `encoding`, `sample_block`: types of messages, their bytes, and the blocks of solver outputs among them.
* `run_log`: `write_log` and `LogWriter` write runs, `read_log` reads them; `study_log`: `StudyLog`, `read_study`.
* `raw_log`: `RawLogWriter` writes messages of any topics; `bag`: `LogReader` and `raw_messages` read any log by time.
* `recover`: what can be saved of a damaged log; `export`: CSV, Parquet, NetCDF; `layouts`: files for other viewers.
* `mcap_read`, `mcap_write`: the file format.
"""
