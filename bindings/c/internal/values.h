// Between the values of the C API and the library's: structs that begin with their size, texts, lists, matrices.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <functional>
#include <iterator>
#include <string>
#include <string_view>
#include <type_traits>

#include "sightline/bindings/c/internal/call.h"
#include "sightline/core/affine.h"
#include "sightline/core/view.h"
#include "sightline/sightline.h"

namespace sightline::capi {

/// Size of a struct when it first came out: no program has a smaller one.
template <class T>
inline constexpr std::size_t kFirstSize = sizeof(T);
template <>
inline constexpr std::size_t kFirstSize<sl_import_report> = offsetof(sl_import_report, from_cache);
template <>
inline constexpr std::size_t kFirstSize<sl_node_info> = offsetof(sl_node_info, part);
template <>
inline constexpr std::size_t kFirstSize<sl_engine_info> = offsetof(sl_engine_info, scratch_bytes);
template <>
inline constexpr std::size_t kFirstSize<sl_frame_report> = offsetof(sl_frame_report, triangles);
template <>
inline constexpr std::size_t kFirstSize<sl_loss_report> = offsetof(sl_loss_report, lod_error);
template <>
inline constexpr std::size_t kFirstSize<sl_ray> = offsetof(sl_ray, hit_ghosts);

/// Whether programs of other versions may have another size. Settings may not: a new one may come among others.
template <class T>
inline constexpr bool kGrows = !std::is_same_v<T, sl_engine_config> && !std::is_same_v<T, sl_paged_config> &&
                               !std::is_same_v<T, sl_import_options> && !std::is_same_v<T, sl_write_options>;

/// No version will have a larger struct: a larger size was never set.
inline constexpr std::size_t kMostSize = 4096;

template <class T>
std::size_t checked_size(const T* from) {
  static_assert(std::is_trivially_copyable_v<T> && offsetof(T, size) == 0);
  require(from != nullptr, "a struct, found null");
  if (from->size < kFirstSize<T> || from->size > kMostSize)
    refuse(SL_ERROR_ARGUMENT, "a struct's size is " + std::to_string(from->size) + ", expected " +
                                  std::to_string(sizeof(T)) + ": initialise it with its SL_..._INIT");
  if (!kGrows<T> && from->size > sizeof(T))
    refuse(SL_ERROR_UNSUPPORTED, "settings are those of another version of the library");
  return from->size;
}

/// The caller's struct. A program made for an older version has fewer fields: the rest is as in `defaults`. One made
/// for a newer version has more: they must be zero.
template <class T>
T read(const T* from, const T& defaults) {
  const std::size_t size = checked_size(from);
  const char* bytes = reinterpret_cast<const char*>(from);
  if (size > sizeof(T) && std::any_of(bytes + sizeof(T), bytes + size, [](char byte) { return byte != 0; }))
    refuse(SL_ERROR_UNSUPPORTED, "a struct has fields that this version of the library does not know");
  T to = defaults;
  std::memcpy(&to, bytes, std::min(size, sizeof(T)));
  return to;
}

/// As much of `from` as the caller's struct holds; zero beyond. The struct keeps its size.
template <class T>
void write(T* to, T from) {
  const std::size_t size = checked_size(to);
  from.size = std::uint32_t(size);
  char* bytes = reinterpret_cast<char*>(to);
  const std::size_t known = std::min(size, sizeof(T));
  std::memcpy(bytes, &from, known);
  std::memset(bytes + known, 0, size - known);
}

/// For results that are written last: refuses them before anything is changed.
template <class T>
void check_result(const T* result) {
  if constexpr (requires { result->size; })
    (void)checked_size(result);
  else
    require(result != nullptr, "room for the result, found null");
}

/// Refuses a buffer that a list or text cannot be written to.
inline void check_buffer(const void* buffer, std::size_t capacity) {
  require(buffer != nullptr || capacity == 0, "a buffer, found null with a capacity above 0");
}

/// Longer arrays of what a caller lists by hand (conditions, views, paths) are mistakes.
inline constexpr std::size_t kMostListed = std::size_t(1) << 16;

/// Refuses an array that is null, and one that is longer than any can be: to walk over it would leave the caller's
/// memory.
inline void check_array(const void* array, std::size_t count, std::size_t most) {
  require(array != nullptr || count == 0, "an array, found null with a count above 0");
  if (count > most)
    refuse(SL_ERROR_ARGUMENT,
           "expected an array of at most " + std::to_string(most) + ", found a count of " + std::to_string(count));
}

void check_text(const sl_text* text);
/// check_text() must have been called.
void write_text(sl_text* text, std::string_view from);

/// check_buffer() must have been called. `convert` makes a T of an element.
template <class T, class List, class Convert>
void write_list(const List& from, T* to, std::size_t capacity, std::size_t* count, const Convert& convert) {
  const std::size_t fits = std::min(capacity, from.size());
  std::transform(from.begin(), std::next(from.begin(), std::ptrdiff_t(fits)), to, convert);
  *count = from.size();
}
template <class T, class List>
void write_list(const List& from, T* to, std::size_t capacity, std::size_t* count) {
  const std::size_t fits = std::min(capacity, from.size());
  if (fits > 0) std::memcpy(to, from.data(), fits * sizeof(T));
  *count = from.size();
}

inline std::string_view text_or_empty(const char* text) {
  return text ? std::string_view(text) : std::string_view();
}
std::string_view required_text(const char* text);
std::filesystem::path path_of(const char* path);  ///< of UTF-8

/// A value of an enumeration whose enumerators are 0 … count - 1.
template <class Enum>
Enum enum_of(std::int32_t value, std::int32_t count, const char* name) {
  if (value < 0 || value >= count)
    refuse(SL_ERROR_ARGUMENT, std::string(name) + ": no such value: " + std::to_string(value));
  return Enum(value);
}

/// Null: the identity. Refuses a last row other than 0 0 0 1.
core::Affine affine_of(const double* matrix);
void write_affine(const core::Affine& from, double matrix[16]);

core::dvec3 vector_of(const double vector[3]);
/// Refuses components beyond 1e150, which rays and queries do not take.
core::dvec3 short_vector_of(const double vector[3]);
core::AabbD box_of(const sl_box& box);
sl_box box_of(const core::AabbD& box);
core::Plane plane_of(const sl_plane& plane);
core::View view_of(const sl_view* view);

/// The caller's function; none where there is none. An exception that leaves it, in an application in C++, cancels: it
/// could not pass the library's threads.
std::function<bool(double)> progress_of(std::int32_t (*progress)(double share, void* user), void* user);

}  // namespace sightline::capi
