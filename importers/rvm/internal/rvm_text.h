// The text form of RVM (.rvm, .rev): the same chunks as lines. There is no public description; this follows what public
// converters write and what users show of their files.
//
//   HEAD                     tag, alone on its line
//        1     1             two numbers: the binary form's third word, and the chunk's version
//   info, note, date, user   a line each, which may be empty; in version 2 encoding, too, where the file has it
//   MODL       1 1, then lines: project, name
//   CNTB       1 2, then the name's line, reference point x y z in millimetres, colour index, transparency if any
//   PRIM       1 1, kind, three rows of the matrix (x y z of the axes, then the origin), box, parameters as in the
//   binary
//              form; a facet group's counts and vertices with normals
//   OBST INSU  the same, with the transparency on a line of its own before the matrix or after the box, or without it
//   COLR       1 1, index, red green blue
//   CNTE, END: 1 1
//
// Numbers may touch where the second has a sign, since columns have a fixed width.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sightline/importers/internal/import_job.h"

namespace sightline::importers {

/// Where a chunk of an image stands in the text it was made from.
struct RvmTextPlace {
  std::uint64_t image_offset = 0, text_offset = 0, line = 0;
};

/// A binary RVM file with the content of a text.
struct RvmImage {
  std::vector<std::byte> bytes;
  std::vector<RvmTextPlace> places;  // in rising order
};

/// Whether the file begins with the text "HEAD".
bool is_rvm_text(std::span<const std::byte> bytes);

/// Damage is what is not as above. Strict: the first is an error with its line. Lenient: the chunk that holds it is
/// left out (a group keeps its nesting), with a warning, and reading goes on with the next line that is a tag.
core::Expected<RvmImage> image_of_rvm_text(ImportJob& job, std::span<const std::byte> text);

}  // namespace sightline::importers
