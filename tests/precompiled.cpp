// The precompiled header is compiled with the flags of this file.
