// Internal to the importers: what the readers of VTK's two families of files share: the bytes, the memory limit, and
// arrays of numbers.
//
// Why VTK's own readers do not read these files: they trust the counts in a file, allocate by them, and walk
// connectivity before anyone can check it. A guard in front of them would have to find every array and look at every
// cell; that is reading the file. The readers here make VTK's data sets again, and vtk_surface.h checks them.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <vtkDataObject.h>
#include <vtkSmartPointer.h>

#include "sightline/importers/internal/byte_order.h"
#include "sightline/importers/vtk/internal/vtk_surface.h"

class vtkDataArray;

namespace sightline::importers {

/// Decoded arrays of a file may take this many times its bytes, plus the constant.
inline constexpr std::size_t kVtkDecodedFactor = 64, kVtkDecodedConstant = std::size_t{1} << 20;

using Number = NumberType;

/// One file being read.
struct VtkFile {
  std::span<const std::byte> bytes;
  std::string part;  ///< "NAME: " for a file that another names, for messages; else empty
  Share share;

  ImportJob& job() const { return share.job; }
  /// Throws an ImportFault, as the functions do that follow.
  [[noreturn]] void fail(std::size_t at, std::string_view message) const;
  /// Whether a lenient import goes on without what had the fault.
  bool may_leave_out(const ImportFault& fault) const {
    return job().options().lenient && fault.error.message != kCancelled;
  }
  void progress(std::size_t at) const { value_or_throw(share.progress(double(at) / double(bytes.size()))); }
  /// Counts `count` values of `size` bytes, which the file promises at `at`, against the memory limit.
  void claim(std::size_t at, std::uint64_t count, std::size_t size);

  std::size_t claimed = 0;
};

/// The array type that a reader wants.
enum class Wanted : std::uint8_t {
  kPoints,   ///< vtkDoubleArray
  kNormals,  ///< vtkFloatArray
  kIds,      ///< vtkTypeInt64Array, from integers only
  kBytes,    ///< vtkUnsignedCharArray, from single bytes only; ascii: 0 to 255
};
/// An array of `count` values. Null when `wanted` takes no such numbers.
vtkSmartPointer<vtkDataArray> make_array(Wanted wanted, Number from, std::size_t count);

/// Fills the array from raw numbers. `data` holds at least as many as the array.
void fill_from_raw(vtkDataArray& to, Number from, std::span<const std::byte> data, bool big_endian);
/// Fills the array from the words of `text`, which may hold more. Returns how many bytes that took, and throws where
/// the file is damaged. `at` is the text's position in the file.
std::size_t fill_from_text(vtkDataArray& to, std::string_view text, const VtkFile& file, std::size_t at);

/// The next word of `text` from `at` on; moves `at` behind it. Empty at the end.
std::string_view next_word(std::string_view text, std::size_t& at);
/// Parses a whole number >= 0. Returns false when the word is none, or when it does not fit.
bool parse_count(std::string_view word, std::uint64_t& count);

inline std::string_view as_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace sightline::importers
