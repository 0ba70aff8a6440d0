"""What an accelerometer on a bearing hears: records from files, their envelope spectrum, the lines of damage in it.

* `records`: `read_record`, acceleration over time from logs, bags, tables and arrays.
* `envelope`: `spectrum_of`, the spectrum of the envelope of a record, the lines of damage and a verdict.
* `picture`: `draw_spectrum`.
"""
