// Images as numpy arrays: files, and comparison for regression tests.
//
// The library's images own their memory. An image that it makes is handed over as it is; one that comes from Python is
// copied.
#include "sightline/bindings/python/images.h"

#include <cmath>

#include "sightline/bindings/python/module.h"
#include "sightline/bindings/python/values.h"
#include "sightline/render/image/image.h"
#include "sightline/render/image/image_metrics.h"

namespace sightline::python {
namespace {

/// A copy of an array of (height, width) or (height, width, 3) numbers, whose width and height fit the library's ints.
template <class Image, class T>
Image image_of(const Numbers<T>& array, std::vector<T> Image::*values, const char* argument) {
  constexpr py::ssize_t kMost = 1 << 30;
  if (array.shape(0) > kMost || array.shape(1) > kMost) fail(std::string(argument) + ": it is too large");
  Image image{int(array.shape(1)), int(array.shape(0)), {}};
  (image.*values).assign(array.data(), array.data() + array.size());
  return image;
}

image::Image colour_image(py::handle value, const char* argument) {
  return image_of(bytes(value, argument, {-1, -1, 3}), &image::Image::pixels, argument);
}

image::IdImage id_image(py::handle value, const char* argument) {
  return image_of(indices(value, argument, {-1, -1}), &image::IdImage::ids, argument);
}

image::DepthImage depth_image(py::handle value, const char* argument) {
  return image_of(floats(value, argument, {-1, -1}), &image::DepthImage::metres, argument);
}

struct Pair {
  image::Image reference, image;
  Pair(py::handle reference_, py::handle image_)
      : reference(colour_image(reference_, "reference")), image(colour_image(image_, "image")) {}
};

void check_for_flip(const Pair& pair, double pixels_per_degree) {
  if (!(pixels_per_degree >= 1.0 && pixels_per_degree <= 1000.0))
    fail("pixels_per_degree: expected 1 to 1000, found " + std::string(py::repr(py::float_(pixels_per_degree))));
  if (pair.reference.pixels.empty()) fail("reference: expected an image with pixels");
  unwrap(image::compare(pair.reference, pair.image));  // of equal size
}

/// Runs without the GIL what neither reads nor makes Python objects.
template <class Work>
auto without_gil(const Work& work) {
  const py::gil_scoped_release released;
  return work();
}

void bind_comparison(py::module_& m) {
  using image::ImageDifference, image::ImageMetrics;
  py::class_<ImageDifference> difference(m, "ImageDifference",
                                         "Differences over all channels of all pixels, 0 to 255.");
  difference.def_readonly("max", &image::ImageDifference::max, "The largest.")
      .def_readonly("mean", &image::ImageDifference::mean, "The mean.")
      .def_readonly("pixels", &image::ImageDifference::pixels, "Pixels that differ at all.")
      .def("__repr__", [](const image::ImageDifference& d) {
        return "<sightline.ImageDifference max " + std::to_string(d.max) + ", mean " + std::to_string(d.mean) +
               ", pixels " + std::to_string(d.pixels) + ">";
      });
  bind_value<&ImageDifference::max, &ImageDifference::mean, &ImageDifference::pixels>(difference);
  py::class_<ImageMetrics> metrics(m, "ImageMetrics", "Measures of a visible difference.");
  metrics.def_readonly("psnr", &image::ImageMetrics::psnr, "Decibels; infinite for equal images.")
      .def_readonly("ssim", &image::ImageMetrics::ssim, "Structural similarity; 1 for equal images.")
      .def_readonly("flip_mean", &image::ImageMetrics::flip_mean, "Mean of FLIP, 0 to 1.")
      .def_readonly("flip_p99", &image::ImageMetrics::flip_p99, "99 % of all pixels have a smaller FLIP.");
  bind_value<&ImageMetrics::psnr, &ImageMetrics::ssim, &ImageMetrics::flip_mean, &ImageMetrics::flip_p99>(metrics);
  m.def(
      "compare",
      [](const py::object& reference, const py::object& image) {
        const Pair pair(reference, image);
        return unwrap(without_gil([&] { return image::compare(pair.reference, pair.image); }));
      },
      py::arg("reference"), py::arg("image"), "The largest and the mean difference of two (height, width, 3) images.");
  m.def(
      "metrics",
      [](const py::object& reference, const py::object& image, double pixels_per_degree) {
        const Pair pair(reference, image);
        check_for_flip(pair, pixels_per_degree);
        return unwrap(without_gil([&] { return image::image_metrics(pair.reference, pair.image, pixels_per_degree); }));
      },
      py::arg("reference"), py::arg("image"), py::kw_only(), py::arg("pixels_per_degree") = image::kPixelsPerDegree,
      "PSNR, SSIM and FLIP of two images of 11 pixels or more either way.");
  m.def(
      "flip",
      [](const py::object& reference, const py::object& image, double pixels_per_degree) {
        const Pair pair(reference, image);
        check_for_flip(pair, pixels_per_degree);
        image::DepthImage errors{pair.reference.width, pair.reference.height, {}};
        errors.metres = without_gil([&] { return image::flip(pair.reference, pair.image, pixels_per_degree); });
        return to_array(std::move(errors));
      },
      py::arg("reference"), py::arg("image"), py::kw_only(), py::arg("pixels_per_degree") = image::kPixelsPerDegree,
      "FLIP's error of each pixel, (height, width) float32, 0 to 1: what somebody sees who flips between both.");
  m.def(
      "difference_image",
      [](const py::object& reference, const py::object& image) {
        const Pair pair(reference, image);
        unwrap(image::compare(pair.reference, pair.image));  // of equal size
        return to_array(without_gil([&] { return image::difference_image(pair.reference, pair.image); }));
      },
      py::arg("reference"), py::arg("image"), "Absolute differences, four times amplified, as an image.");
  m.def(
      "wrong_ids",
      [](const py::object& reference, const py::object& ids) {
        return unwrap(image::wrong_ids(id_image(reference, "reference"), id_image(ids, "ids")));
      },
      py::arg("reference"), py::arg("ids"), "Number of pixels that show another item, of two arrays of read_ids().");
}

void bind_files(py::module_& m) {
  m.def(
      "read_png",
      [](const std::filesystem::path& file) {
        return to_array(unwrap(without_gil([&] { return image::read_png(file); })));
      },
      py::arg("file"), "A PNG file as (height, width, 3) uint8.");
  m.def(
      "write_png",
      [](const std::filesystem::path& file, const py::object& image) {
        const image::Image colours = colour_image(image, "image");
        unwrap(without_gil([&] { return image::write_png(colours, file); }));
      },
      py::arg("file"), py::arg("image"), "Replaces the file. `image`: (height, width, 3) uint8.");
  m.def(
      "encode_png",
      [](const py::object& image) {
        const image::Image colours = colour_image(image, "image");
        const auto data = unwrap(without_gil([&] { return image::encode_png(colours, image::PngSize::kSmall); }));
        return py::bytes(reinterpret_cast<const char*>(data.data()), data.size());
      },
      py::arg("image"), "The bytes of a PNG file, as notebooks and HTML pages take them.");
  m.def(
      "write_pfm",
      [](const std::filesystem::path& file, const py::object& depth) {
        unwrap(image::write_pfm(depth_image(depth, "depth"), file));
      },
      py::arg("file"), py::arg("depth"), "Writes what read_depth() gives, in metres.");
  m.def(
      "id_colours", [](const py::object& ids) { return to_array(unwrap(image::id_colours(id_image(ids, "ids")))); },
      py::arg("ids"), "Ids as 24-bit colours, red the low byte, as sightline-render writes them.");
  m.def(
      "ids_of_colours",
      [](const py::object& colours) { return to_array(image::ids_of_colours(colour_image(colours, "colours"))); },
      py::arg("colours"), "The inverse of id_colours().");
}

}  // namespace

py::array_t<std::uint8_t> to_array(image::Image&& image) {
  const Shape shape{image.height, image.width, 3};
  return take(std::move(image), &image::Image::pixels, shape);
}

py::array_t<std::uint32_t> to_array(image::IdImage&& image) {
  const Shape shape{image.height, image.width};
  return take(std::move(image), &image::IdImage::ids, shape);
}

py::array_t<float> to_array(image::DepthImage&& image) {
  const Shape shape{image.height, image.width};
  return take(std::move(image), &image::DepthImage::metres, shape);
}

void bind_images(py::module_& m) {
  bind_comparison(m);
  bind_files(m);
}

}  // namespace sightline::python
