"""Which of a process's interpreters this is."""

import ctypes


def subinterpreter() -> int:
    """The number of this subinterpreter; 0 in the process's main interpreter.

    In a subinterpreter the import of an extension made by pybind11 waits for ever for the interpreter lock.
    """
    api = ctypes.pythonapi
    api.PyInterpreterState_Get.restype = ctypes.c_void_p
    api.PyInterpreterState_GetID.argtypes = [ctypes.c_void_p]
    api.PyInterpreterState_GetID.restype = ctypes.c_int64
    return api.PyInterpreterState_GetID(api.PyInterpreterState_Get())
