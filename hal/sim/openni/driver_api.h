// OpenNI2's interface for drivers, which needs two macros that its packages leave out.
#pragma once

#define XN_NEW(type, ...) new type(__VA_ARGS__)
#define XN_DELETE(pointer) delete (pointer)

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wpedantic"
#include <Driver/OniDriverAPI.h>
#pragma GCC diagnostic pop
