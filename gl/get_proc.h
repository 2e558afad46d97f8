// How an application hands its OpenGL over: a function that finds entry points. Needs no header of GL's.
#pragma once

namespace sightline::gl {

using Proc = void (*)();
/// Finds an entry point by its full name ("glEnable"); null when unknown. `user` is the pointer given with the
/// callback. eglGetProcAddress, OSMesaGetProcAddress and glfwGetProcAddress each fit with a one-line wrapper.
using GetProc = Proc (*)(const char* name, void* user);

}  // namespace sightline::gl
