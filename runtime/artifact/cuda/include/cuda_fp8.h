// AOTInductor's headers include this, and its code for the host uses nothing of it.
