"""Many photos, on the processes of this machine or on a cluster's: `graphstipple batch` and `graphstipple.batch`.

In: folders, globs, lists and addresses -> `sources` (photos, with their places in the tree) -> `names` (of the files that are
drawn) -> `work` (one photo in, its files and hashes out), by workers of `local` or `cluster` -> `store` (the output) and `manifest`
(a line a photo). `run` ties these together, `command` is the command line, `api` is Python's.
"""
