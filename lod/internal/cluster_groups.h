// Which clusters are simplified together. Internal to lod.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace sightline::lod {

/// Two clusters that touch, and along how many edges.
struct Contact {
  std::uint32_t a, b, edges;
};

/// The group of each of `count` clusters, numbered from 0 in the order of their first clusters. Groups have at most
/// `most` clusters, and clusters of a group touch each other along many edges, so that few edges lie between groups.
/// Clusters without contact to others that are left are grouped with their successors. Deterministic.
std::vector<std::uint32_t> group_clusters(std::uint32_t count, std::span<const Contact> contacts, std::uint32_t most);

}  // namespace sightline::lod
