"""What an accelerometer on a bearing hears: the envelope spectrum of a record, the lines of damage in it.

* `fault_frequencies`: `rolling_frequencies` of a ball set.
* `envelope`: `spectrum_of`, the spectrum of the envelope of a record, the lines of damage and a verdict.
* `picture`: `draw_spectrum`.
"""
