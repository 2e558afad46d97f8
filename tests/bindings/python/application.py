"""An application's GL context and framebuffer, made with ctypes: what stands for GLFW, Qt and PyOpenGL in tests."""

import ctypes
import unittest

import numpy as np

# Numbers of EGL and GL, by their names there.
EGL_PLATFORM_SURFACELESS_MESA, EGL_OPENGL_API, EGL_NONE = 0x31DD, 0x30A2, 0x3038
EGL_CONTEXT_MAJOR_VERSION, EGL_CONTEXT_MINOR_VERSION = 0x3098, 0x30FB
GL_RGBA8, GL_DEPTH_COMPONENT24, GL_RENDERBUFFER = 0x8058, 0x81A6, 0x8D41
GL_COLOR_ATTACHMENT0, GL_DEPTH_ATTACHMENT, GL_COLOR, GL_DEPTH = 0x8CE0, 0x8D00, 0x1800, 0x1801
GL_READ_FRAMEBUFFER, GL_RGBA, GL_UNSIGNED_BYTE = 0x8CA8, 0x1908, 0x1401

Pointer, Enum, Int, Name = ctypes.c_void_p, ctypes.c_uint, ctypes.c_int, ctypes.c_uint


class Application:
    """Has a context of EGL's, without a window, current on the thread that makes it. Skips where there is none."""

    def __init__(self):
        try:
            self.egl = ctypes.CDLL("libEGL.so.1")
        except OSError as error:
            raise unittest.SkipTest(str(error))
        self.display = self.call("eglGetPlatformDisplay", Pointer, Enum(EGL_PLATFORM_SURFACELESS_MESA), None, None)
        if not self.display or not self.call("eglInitialize", Int, Pointer(self.display), None, None):
            raise unittest.SkipTest("EGL: no display without a surface")
        self.contexts = []
        self.new_context()

    def call(self, name, result, *arguments):
        function = self.egl[name]
        function.restype = result
        return function(*arguments)

    def new_context(self):
        """Another context, current from now on."""
        self.call("eglBindAPI", Int, Enum(EGL_OPENGL_API))
        wanted = (Int * 5)(EGL_CONTEXT_MAJOR_VERSION, 4, EGL_CONTEXT_MINOR_VERSION, 5, EGL_NONE)
        context = self.call("eglCreateContext", Pointer, Pointer(self.display), None, None, wanted)
        if not context:
            raise unittest.SkipTest("EGL: no context of OpenGL 4.5")
        self.contexts.append(context)
        self.make_current(context)

    def make_current(self, context):
        done = self.call("eglMakeCurrent", Int, Pointer(self.display), None, None, Pointer(context))
        assert done, "eglMakeCurrent"

    def destroy_context(self):
        """Destroys the one that is current."""
        self.make_current(None)
        self.call("eglDestroyContext", Int, Pointer(self.display), Pointer(self.contexts.pop()))

    def address(self, name):
        """As binding libraries find functions: an address, or None."""
        return self.call("eglGetProcAddress", Pointer, ctypes.c_char_p(name.encode()))

    def gl(self, name, *arguments):
        ctypes.CFUNCTYPE(None)(self.address(name))(*arguments)

    def close(self):
        while self.contexts:
            self.destroy_context()


class Framebuffer:
    """Colour and depth, red and far away."""

    def __init__(self, application, width, height):
        self.gl, self.width, self.height = application.gl, width, height
        names = (Name * 3)()
        self.gl("glCreateRenderbuffers", Int(2), names)
        self.gl("glNamedRenderbufferStorage", Name(names[0]), Enum(GL_RGBA8), Int(width), Int(height))
        self.gl("glNamedRenderbufferStorage", Name(names[1]), Enum(GL_DEPTH_COMPONENT24), Int(width), Int(height))
        made = Name()
        self.gl("glCreateFramebuffers", Int(1), ctypes.byref(made))
        self.name = made.value
        for attachment, buffer in ((GL_COLOR_ATTACHMENT0, names[0]), (GL_DEPTH_ATTACHMENT, names[1])):
            self.gl("glNamedFramebufferRenderbuffer", Name(self.name), Enum(attachment), Enum(GL_RENDERBUFFER),
                    Name(buffer))
        self.gl("glClearNamedFramebufferfv", Name(self.name), Enum(GL_COLOR), Int(0), (ctypes.c_float * 4)(1, 0, 0, 1))
        self.gl("glClearNamedFramebufferfv", Name(self.name), Enum(GL_DEPTH), Int(0), (ctypes.c_float * 1)(1))

    def read(self):
        """(height, width, 3) uint8, rows from the top."""
        pixels = np.zeros((self.height, self.width, 4), np.uint8)
        self.gl("glBindFramebuffer", Enum(GL_READ_FRAMEBUFFER), Name(self.name))
        self.gl("glReadPixels", Int(0), Int(0), Int(self.width), Int(self.height), Enum(GL_RGBA), Enum(GL_UNSIGNED_BYTE),
                pixels.ctypes.data_as(Pointer))
        return pixels[::-1, :, :3].copy()
