"""Pictures: arrays in, axes out.

* `style`: colours, headings and frames of panels; `save`, `write_moving`: files.
* `run`: `RunPicture`, what pictures of runs share; `ChannelPicture`: one of channels alone.
* `panels`: loads around a bearing, peaks of contacts, errors of figures; `contact`: the picture of a Hertz contact.
"""
