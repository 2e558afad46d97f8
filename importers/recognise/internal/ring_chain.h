// Internal to the recognition of primitives: flat faces of a solid, and the rings of vertices that lead from one of
// them around it.
#pragma once

#include <cstdint>
#include <vector>

#include "sightline/importers/recognise/internal/solids.h"

namespace sightline::importers::recognition {

/// Neighbouring triangles whose vertices lie in one plane.
struct Face {
  dvec3 normal{0.0};  ///< unit, the mean of its triangles'
  double area = 0.0;
  std::uint32_t seed = 0;      ///< its largest triangle
  std::uint32_t boundary = 0;  ///< half-edges whose twins lie in other faces, or are missing
};
struct Faces {
  std::vector<Face> faces;
  std::vector<std::uint32_t> of_triangle;
};
/// Grows faces from the largest triangles to the smallest. `distance`: of a vertex from the plane so far.
void find_faces(const Solid& solid, double distance, Faces& out);

/// A closed polygon of vertices across a solid, or a single vertex, a pole.
struct Ring {
  std::vector<std::uint32_t> vertices;
  std::vector<std::uint32_t> inner;  ///< half-edges from each vertex to the next, in the triangles before the ring
  bool is_pole() const { return vertices.size() == 1; }
};

/// Rings in order. Between ring k and k + 1 lies band k: a closed strip of triangles that have corners on both.
struct RingChain {
  std::vector<Ring> rings;
  std::vector<std::vector<std::uint32_t>> bands;
  std::vector<std::uint32_t> first_cap, last_cap;  ///< triangles within the first and the last ring
  bool whole = false;                              ///< the chain has all triangles of the solid
};

/// Walks from the boundary of a face over the solid until a ring is the whole boundary of another face, or a pole, or
/// no strip leads on. False when the face's boundary is not one simple loop.
bool chain_from_face(const Solid& solid, const Faces& faces, std::uint32_t face, RingChain& out);

/// Walks a chain from the fan of triangles around a vertex.
bool chain_from_pole(const Solid& solid, const Faces& faces, std::uint32_t half_edge, RingChain& out);

}  // namespace sightline::importers::recognition
