"""Topics of a run as messages, and logs of them as MCAP files: no ROS is needed.

* `stream`: the topics of a scene, their table in words, and their messages.
* `cdr`: types of messages and their bytes.
* `run_log`: logs of runs, written and read.
* `study_log`: logs of studies, written and read.
* `raw_log`: logs of messages of any topics, written; what is whole of a damaged log.
* `bag`: logs of any program, read by time, and the quality of service of topics.
* `export`: CSV, Parquet and NetCDF.
* `layouts`: layouts of other viewers.
* `acceleration_record`: records of acceleration from tables and logs, `read_record`.
* `mcap_read`: limits of a file (`LARGEST_MESSAGE`, `MOST_TOPICS`), and one that cannot be read (`DamagedLog`).
* `mcap_write`: the writer of files (`McapWriter`), the bytes that it holds (`CHUNK_BYTES`, `HELD_BYTES`), topics of a
  file (`StoredTopic`), and a disk without room (`FullDisk`).
"""
