#include "sightline/core/internal/stored_attributes.h"

#include <cstring>
#include <string_view>

namespace sightline::core {
namespace {

/// Takes bytes off the front of a text.
class Taker {
 public:
  explicit Taker(std::string_view text) : rest_(text) {}
  bool number(std::uint32_t& value) {
    if (rest_.size() < sizeof value) return false;
    std::memcpy(&value, rest_.data(), sizeof value);
    rest_.remove_prefix(sizeof value);
    return true;
  }
  bool text(std::size_t length, std::string& value) {
    if (rest_.size() < length) return false;
    value = rest_.substr(0, length);
    rest_.remove_prefix(length);
    return true;
  }

 private:
  std::string_view rest_;
};

void append(LargeArray<char>& to, std::string_view bytes) {
  to.insert(to.end(), bytes.begin(), bytes.end());
}

void append_number(LargeArray<char>& to, std::size_t value) {
  const auto number = std::uint32_t(value);
  char bytes[sizeof number];
  std::memcpy(bytes, &number, sizeof number);
  append(to, {bytes, sizeof number});
}

}  // namespace

std::size_t StoredAttributes::find(std::uint32_t node) const {
  const auto* const found = std::lower_bound(nodes.begin(), nodes.end(), node);
  return found != nodes.end() && *found == node ? std::size_t(found - nodes.begin()) : nodes.size();
}

StoredAttributes::List StoredAttributes::list(std::size_t index) const {
  List list;
  const std::uint64_t begin = index == 0 ? 0 : ends[index - 1], end = ends[index];
  if (begin > end || end > text.size()) return list;
  Taker taker(std::string_view(text.data() + begin, std::size_t(end - begin)));
  std::uint32_t key_length = 0, value_length = 0;
  std::string key, value;
  while (taker.number(key_length) && taker.number(value_length) && taker.text(key_length, key) &&
         taker.text(value_length, value))
    list.emplace_back(std::move(key), std::move(value));
  return list;
}

void StoredAttributes::add(std::uint32_t node, const List& list) {
  for (const auto& [key, value] : list) {
    append_number(text, key.size());
    append_number(text, value.size());
    append(text, key);
    append(text, value);
  }
  nodes.push_back(node);
  ends.push_back(text.size());
}

const StoredAttributes::List* AttributeReader::find(std::uint32_t node) const {
  const std::size_t index = stored_->find(node);
  if (index == stored_->nodes.size()) return nullptr;
  const std::lock_guard held(mutex_);
  auto [entry, fresh] = read_.try_emplace(node);
  if (fresh) entry->second = stored_->list(index);
  return &entry->second;
}

}  // namespace sightline::core
