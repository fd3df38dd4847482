"""Work spread over processes and machines: runs of numbered items, whose results come back in any order.

- `gather` what is left, how much to hand out at once, and taking in
- `processes` of this machine and the memory they keep, `cluster` of Dask
- `forks`: processes of this machine for the tasks or items of one stage; its cores

A piece, then a part. A long sweep is cut into pieces of consecutive cells, by what the last pieces cost. Who computes
them (`concurrent.futures`: processes, or Dask) knows a function of two numbers, and returns bytes: the files of the
piece's two tables. A piece that is a whole part is put in its place as it is; others are kept, put together in order,
and written as parts of the same fixed number of cells by the one process that writes. So neither the number of
workers nor what became of them shows in a byte, memory is bounded by a part, and a rerun asks only for the cells that
no piece or part holds. A worker that dies costs its piece, which is done again in halves.
"""
