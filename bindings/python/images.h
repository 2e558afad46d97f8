// Images of the library as arrays that own them.
#pragma once

#include "sightline/bindings/python/convert.h"
#include "sightline/render/image/image.h"

namespace sightline::python {

py::array_t<std::uint8_t> to_array(image::Image&& image);     ///< (height, width, 3)
py::array_t<std::uint32_t> to_array(image::IdImage&& image);  ///< (height, width): item + 1, 0 background
py::array_t<float> to_array(image::DepthImage&& image);       ///< (height, width): metres, infinite where nothing is

}  // namespace sightline::python
