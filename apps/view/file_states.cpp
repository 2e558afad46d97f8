#include "sightline/apps/view/file_states.h"

#include <system_error>

namespace sightline::apps {

FileState state_of(const std::filesystem::path& file) {
  std::error_code none;
  FileState state{std::filesystem::exists(file, none), 0, {}};
  if (!state.there) return state;
  state.changed = std::filesystem::last_write_time(file, none);
  state.bytes = std::filesystem::is_regular_file(file, none) ? std::filesystem::file_size(file, none) : 0;
  return state;
}

const FileState& FileStates::of(const std::string& file) {
  const double now = clock_();
  const auto found = known_.find(file);
  if (found != known_.end() && now - found->second.at < kSeconds) return found->second.state;
  return known_.insert_or_assign(file, Asked{ask_(file), now}).first->second.state;
}

}  // namespace sightline::apps
