"""The use case `make study WHAT=distributed`: a composed op sent to several processes, and an optimisation by
all of them, both equal to one process's."""
