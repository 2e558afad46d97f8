// Internal to the importers: entities in the text of a STEP file (ISO 10303-21), for what Open CASCADE does not read.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace sightline::importers {

/// A keyword and its parameters, as they stand in the text.
struct StepRecord {
  std::string_view keyword;
  std::vector<std::string_view> parameters;
};

/// Lists the entities of a text without comments (repaired_step()), which must outlive it. Damage ends the list, or
/// gives entities without records.
class StepText {
 public:
  struct Entity {
    std::uint64_t id;
    std::string_view text;  ///< between '=' and ';'
  };

  explicit StepText(std::string_view text);

  /// By rising number, each once.
  const std::vector<Entity>& entities() const { return entities_; }
  /// Null where there is none.
  const Entity* find(std::uint64_t id) const;
  /// One record, or one for each type of a complex entity; none where there is no such entity.
  std::vector<StepRecord> records(std::uint64_t id) const;

 private:
  std::vector<Entity> entities_;
};

std::vector<StepRecord> step_records(std::string_view entity);
/// The record of a type among those of an entity, or null.
const StepRecord* find_record(const std::vector<StepRecord>& records, std::string_view keyword);

/// The elements of "(a,b,c)"; none where a parameter is no list.
std::vector<std::string_view> step_list(std::string_view parameter);
/// All numbers of a list, and of lists in it, in their order.
std::vector<double> step_numbers(std::string_view parameter);
/// "#12" as 12.
std::optional<std::uint64_t> step_reference(std::string_view parameter);

}  // namespace sightline::importers
