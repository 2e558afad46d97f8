// Internal to the importers: what the readers of VTK's two families of files share: the bytes, how far memory may
// follow them, and arrays of numbers.
//
// Why these files are not left to VTK's own readers: those take the counts of a file for granted, allocate by them, and
// walk connectivity before anyone can check it. A guard that can vouch for a file has to find every array and look at
// every cell; that is reading it. What is made here are VTK's data sets again, and vtk_surface.h checks them.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <vtkDataObject.h>
#include <vtkSmartPointer.h>

#include "sightline/importers/vtk/internal/vtk_surface.h"

class vtkDataArray;

namespace sightline::importers {

/// Arrays of a file may take this many times its bytes, plus the constant, once decoded.
inline constexpr std::size_t kVtkDecodedFactor = 64, kVtkDecodedConstant = std::size_t{1} << 20;

enum class Number : std::uint8_t { kInt8, kUInt8, kInt16, kUInt16, kInt32, kUInt32, kInt64, kUInt64, kFloat, kDouble };
inline constexpr std::size_t kNumberBytes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
constexpr std::size_t bytes_of(Number number) {
  return kNumberBytes[std::size_t(number)];
}

/// One file on its way in.
struct VtkFile {
  std::span<const std::byte> bytes;
  std::string part;  ///< "NAME: " for a file that another names, for messages; else empty
  Share share;

  ImportJob& job() const { return share.job; }
  tl::unexpected<core::Error> fail(std::size_t at, std::string_view message) const;
  /// An error when strict, a warning when lenient.
  core::Expected<void> damage(std::size_t at, std::string_view message) const;
  core::Expected<void> progress(std::size_t at) const { return share.progress(double(at) / double(bytes.size())); }
  /// Reserves memory for `count` values of `size` bytes that the file at `at` promises.
  core::Expected<void> claim(std::size_t at, std::uint64_t count, std::size_t size);

  std::size_t claimed = 0;
};

/// What a reader wants to have an array as.
enum class Wanted : std::uint8_t {
  kPoints,   ///< vtkDoubleArray
  kNormals,  ///< vtkFloatArray
  kIds,      ///< vtkTypeInt64Array, from integers only
  kBytes,    ///< vtkUnsignedCharArray, from single bytes only; ascii: 0 to 255
};
/// Of `count` values. Empty when `wanted` takes no such numbers.
vtkSmartPointer<vtkDataArray> make_array(Wanted wanted, Number from, std::size_t count);

/// Fills the array from as many raw numbers, of which `data` holds at least that many.
void fill_from_raw(vtkDataArray& to, Number from, std::span<const std::byte> data, bool big_endian);
/// Fills the array from the words of `text`, which may hold more. Tells how many bytes that took, and where the file is
/// damaged. `at` is the text's place in the file.
core::Expected<std::size_t> fill_from_text(vtkDataArray& to, std::string_view text, const VtkFile& file,
                                           std::size_t at);

/// The next word of `text` from `at` on, which then stands behind it; empty at the end.
std::string_view next_word(std::string_view text, std::size_t& at);
/// A whole number >= 0 that fits, or nothing.
bool parse_count(std::string_view word, std::uint64_t& count);

inline std::string_view as_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace sightline::importers
