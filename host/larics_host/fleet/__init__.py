"""What `larics fleet` is made of: the logs of many vehicles, read in blocks by many processes.

sources    files behind paths and addresses, cut into blocks of bounded size
passes     one visit under a marker: which of the IDs read there is wrong
track      the vehicle by the map: readings that contradict it, markers that moved
tally      all that a block tells, in numbers that add up
engine     tasks on the cores here or on a Dask cluster, results in the order of the tasks
trends     how margins and lengths change over the time of the logs
places     markers seen off their places in the map, or too far apart
rows       what each vehicle and marker did, for the tables
findings   what is wrong with which vehicle and which marker
report     tables and one HTML page
"""
