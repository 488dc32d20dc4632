"""The studio: turn an option, see the drawing. In a browser (``graphstipple studio``), and in a notebook (`graphstipple.Studio`).

What a page says and sees is the same in both: `desk` has one photo's drawings for one page, and goes by messages; `look` is what a
page asks for, checked. `server` carries the messages over a socket on this machine alone, past `guard`; `notebook` over those of a
widget. The page itself is in `page/`: HTML, CSS and JavaScript as they are, without a build step.
"""
