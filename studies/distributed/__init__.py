"""The use case `make study WHAT=distributed`: a composed op that is sent to several processes, and an
optimisation by all of them; both give the result of a single process."""
