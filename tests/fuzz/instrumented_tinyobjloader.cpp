// The packaged library is not instrumented; its header holds the same code.
#define TINYOBJLOADER_IMPLEMENTATION
#include <tiny_obj_loader.h>
