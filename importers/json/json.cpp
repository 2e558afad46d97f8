#include "sightline/importers/json/internal/json.h"

#include <algorithm>
#include <charconv>
#include <functional>
#include <iterator>
#include <numeric>
#include <optional>
#include <ostream>

#include <nlohmann/json.hpp>

namespace sightline::json {

/// Keys and values at the same indices. `ascending`: each key is greater than the one before.
struct Value::Object {
  std::vector<std::string> keys;
  Array values;
  bool ascending = true;

  /// Where the key is, or keys.size().
  std::size_t find(std::string_view key) const {
    const auto found =
        ascending ? std::lower_bound(keys.begin(), keys.end(), key) : std::find(keys.begin(), keys.end(), key);
    return found != keys.end() && *found == key ? std::size_t(found - keys.begin()) : keys.size();
  }

  Value& append(std::string key) {
    ascending = ascending && (keys.empty() || keys.back() < key);
    keys.push_back(std::move(key));
    return values.emplace_back();
  }
};

namespace {

/// The next name in a JSON pointer, with ~1 for / and ~0 for ~. Removes it from the pointer.
std::string next_name(std::string_view& pointer) {
  pointer.remove_prefix(1);
  const std::string_view raw = pointer.substr(0, pointer.find('/'));
  pointer.remove_prefix(raw.size());
  std::string name;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    const bool escaped = raw[i] == '~' && i + 1 < raw.size() && (raw[i + 1] == '0' || raw[i + 1] == '1');
    name += escaped ? (raw[++i] == '0' ? '~' : '/') : raw[i];
  }
  return name;
}

/// The index that a name in a JSON pointer means, or `size`.
std::size_t index_of(std::string_view name, std::size_t size) {
  std::size_t index = size;
  if (name.starts_with('0') && name != "0") return size;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), index);
  return error == std::errc() && end == name.data() + name.size() ? std::min(index, size) : size;
}

}  // namespace

// --- construction ----------------------------------------------------------------------------------------------------

Value::Value(std::string text) : kind_(Kind::kString), content_{.string = new std::string(std::move(text))} {}

Value::Value(std::initializer_list<Element> elements) {
  const auto is_member = [](const Element& element) {
    const Value& pair = element.value;
    return pair.is_array() && pair.size() == 2 && pair[0].is_string();
  };
  if (!std::all_of(elements.begin(), elements.end(), is_member)) {
    *this = array(elements);
    return;
  }
  *this = object();
  for (const Element& element : elements) {
    Value& pair = element.value;
    if (!contains(pair[0].string())) (*this)[pair[0].string()] = std::move(pair[1]);  // the first of a key counts
  }
}

Value::Value(const Value& other) : kind_(other.kind_), content_(other.content_) {
  if (kind_ == Kind::kString) content_.string = new std::string(*other.content_.string);
  if (kind_ == Kind::kArray) content_.array = new Array(*other.content_.array);
  if (kind_ == Kind::kObject) content_.object = new Object(*other.content_.object);
}

Value Value::array() {
  Value made;
  made.content_.array = new Array;
  made.kind_ = Kind::kArray;
  return made;
}

Value Value::array(std::initializer_list<Element> elements) {
  Value made = array();
  made.content_.array->reserve(elements.size());
  for (const Element& element : elements) made.content_.array->push_back(std::move(element.value));
  return made;
}

Value Value::object() {
  Value made;
  made.content_.object = new Object;
  made.kind_ = Kind::kObject;
  return made;
}

/// Without recursion: hostile text nests deeper than the stack. What a container holds is emptied before it goes.
void Value::destroy() noexcept {
  std::vector<Value> pending;
  const auto empty = [&pending](Value& value) {
    for (Value& child : value)
      if (child.kind_ >= Kind::kArray) pending.push_back(std::move(child));
  };
  if (kind_ >= Kind::kArray) empty(*this);
  while (!pending.empty()) {
    Value last = std::move(pending.back());
    pending.pop_back();
    empty(last);
  }
  if (kind_ == Kind::kString) delete content_.string;
  if (kind_ == Kind::kArray) delete content_.array;
  if (kind_ == Kind::kObject) delete content_.object;
}

// --- access ----------------------------------------------------------------------------------------------------------

const char* Value::type_name() const {
  constexpr const char* kNames[] = {"null", "boolean", "number", "number", "number", "string", "array", "object"};
  return kNames[std::size_t(kind_)];
}

void Value::refuse(const char* expected) const {
  throw TypeError(std::string("expected ") + expected + ", found " + type_name());
}

bool Value::boolean() const {
  if (kind_ != Kind::kBoolean) refuse("a boolean");
  return content_.boolean;
}

const std::string& Value::string() const {
  if (kind_ != Kind::kString) refuse("a string");
  return *content_.string;
}

const Value::Array& Value::checked_array() const {
  if (kind_ != Kind::kArray) refuse("an array");
  return *content_.array;
}

std::pair<const Value*, const Value*> Value::range() const {
  if (kind_ == Kind::kNull) return {this, this};
  if (kind_ < Kind::kArray) return {this, this + 1};
  const Array& values = kind_ == Kind::kArray ? *content_.array : content_.object->values;
  return {values.data(), values.data() + values.size()};
}

const Value& Value::at(std::size_t index) const {
  const Array& elements = checked_array();
  if (index >= elements.size()) throw TypeError("no element " + std::to_string(index));
  return elements[index];
}

const Value& Value::at(std::string_view key) const {
  if (kind_ != Kind::kObject) refuse("an object");
  const Value* found = find_member(key);
  if (!found) throw TypeError("key '" + std::string(key) + "' not found");
  return *found;
}

Value& Value::operator[](std::string_view key) {
  if (kind_ == Kind::kNull) *this = object();
  if (kind_ != Kind::kObject) refuse("an object");
  const std::size_t at = content_.object->find(key);
  return at < content_.object->keys.size() ? content_.object->values[at] : content_.object->append(std::string(key));
}

const Value* Value::find_member(std::string_view key) const {
  if (kind_ != Kind::kObject) return nullptr;
  const std::size_t at = content_.object->find(key);
  return at < content_.object->keys.size() ? &content_.object->values[at] : nullptr;
}

const Value* Value::find(std::string_view key) const {
  const Value* found = find_member(key);
  return found ? found : end();
}

bool Value::contains(std::string_view key) const {
  return find_member(key) != nullptr;
}

Value::Items Value::items() const {
  if (kind_ != Kind::kObject) refuse("an object");
  return {content_.object->keys.data(), begin(), end()};
}

void Value::push_back(Value element) {
  if (kind_ == Kind::kNull) *this = array();
  (void)checked_array();
  content_.array->push_back(std::move(element));
}

void Value::update(const Value& members) {
  if (kind_ == Kind::kNull) *this = object();
  for (const auto& [key, value] : members.items()) (*this)[key] = value;
}

void Value::erase(std::string_view key) {
  if (kind_ != Kind::kObject) refuse("an object");
  const auto at = std::ptrdiff_t(content_.object->find(key));
  if (at == std::ptrdiff_t(content_.object->keys.size())) return;
  content_.object->keys.erase(content_.object->keys.begin() + at);
  content_.object->values.erase(content_.object->values.begin() + at);
}

void Value::erase(std::size_t index) {
  (void)at(index);
  content_.array->erase(content_.array->begin() + std::ptrdiff_t(index));
}

const Value* Value::find_pointer(std::string_view pointer) const {
  const Value* value = this;
  while (value && !pointer.empty()) {
    if (!pointer.starts_with('/')) return nullptr;
    const std::string name = next_name(pointer);
    if (value->is_array()) {
      const std::size_t index = index_of(name, value->size());
      value = index < value->size() ? &value->at(index) : nullptr;
    } else {
      value = value->find_member(name);
    }
  }
  return value;
}

// --- comparison ------------------------------------------------------------------------------------------------------

std::partial_ordering Value::order(const Value& a, const Value& b) {
  if (a.is_string() && b.is_string()) return a.content_.string->compare(*b.content_.string) <=> 0;
  if (!a.is_number() || !b.is_number()) return std::partial_ordering::unordered;
  if (a.kind_ == Kind::kDouble || b.kind_ == Kind::kDouble) return a.get<double>() <=> b.get<double>();
  const bool negative_a = a.kind_ == Kind::kInteger && a.content_.integer < 0;
  const bool negative_b = b.kind_ == Kind::kInteger && b.content_.integer < 0;
  if (negative_a != negative_b) return negative_a ? std::partial_ordering::less : std::partial_ordering::greater;
  return a.get<std::uint64_t>() <=> b.get<std::uint64_t>();
}

bool Value::equal(const Value& a, const Value& b) {
  if (a.is_number() || a.is_string()) return order(a, b) == std::partial_ordering::equivalent;
  if (a.kind_ != b.kind_) return false;
  if (a.kind_ == Kind::kBoolean) return a.content_.boolean == b.content_.boolean;
  if (a.kind_ == Kind::kArray) return *a.content_.array == *b.content_.array;
  if (a.kind_ != Kind::kObject) return true;
  if (a.size() != b.size()) return false;
  for (const auto& [key, value] : a.items()) {
    const Value* other = b.find_member(key);
    if (!other || value != *other) return false;
  }
  return true;
}

// --- sorting ---------------------------------------------------------------------------------------------------------

/// Makes containers of their parts, in any order of keys.
class Builder {
 public:
  static Value array(std::vector<Value> elements) {
    Value made = Value::array();
    *made.content_.array = std::move(elements);
    return made;
  }

  /// The last of several members with one key counts, in the place of the first. With `sort` keys ascend.
  static Value object(std::vector<std::string> keys, std::vector<Value> values, bool sort) {
    Value made = Value::object();
    const bool ascending = std::adjacent_find(keys.begin(), keys.end(), std::greater_equal<>()) == keys.end();
    if (!ascending) arrange(keys, values, sort);
    made.content_.object->ascending = ascending || sort;
    made.content_.object->keys = std::move(keys);
    made.content_.object->values = std::move(values);
    return made;
  }

  /// Sorts the keys of this object, and what its values or elements hold.
  static void sort(Value& value) {
    if (value.is_object() && !value.content_.object->ascending)
      value = object(std::move(value.content_.object->keys), std::move(value.content_.object->values), true);
    if (value.is_array() || value.is_object())
      for (Value& child : value) sort(child);
  }

 private:
  struct Same {
    std::size_t first, last;  // of the members with one key
  };

  static void arrange(std::vector<std::string>& keys, std::vector<Value>& values, bool sort) {
    std::vector<std::size_t> order(keys.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return keys[a] < keys[b]; });
    std::vector<Same> kept;
    for (const std::size_t i : order) {
      if (!kept.empty() && keys[kept.back().first] == keys[i])
        kept.back().last = i;
      else
        kept.push_back({i, i});
    }
    if (!sort) std::sort(kept.begin(), kept.end(), [](const Same& a, const Same& b) { return a.first < b.first; });
    std::vector<std::string> kept_keys(kept.size());
    std::vector<Value> kept_values(kept.size());
    for (std::size_t k = 0; k < kept.size(); ++k) {
      kept_keys[k] = std::move(keys[kept[k].first]);
      kept_values[k] = std::move(values[kept[k].last]);
    }
    keys = std::move(kept_keys);
    values = std::move(kept_values);
  }
};

Value sorted(Value value) {
  Builder::sort(value);
  return value;
}

// --- reading ---------------------------------------------------------------------------------------------------------

namespace {

/// Where the text first nests deeper than max_depth, if it does. The parser's stack is safe at any depth; the stack of
/// code that walks the values may not be.
std::optional<std::size_t> too_deep(std::string_view text, int max_depth) {
  if (max_depth == kAnyDepth) return std::nullopt;
  int depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '[' || c == '{') {
      if (++depth > max_depth) return i;
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return std::nullopt;
}

/// Takes the parser's events. The parts of open arrays and objects wait on two stacks, so that each container is
/// allocated once, with the size it needs.
class Reader {
 public:
  explicit Reader(bool sort) : sort_(sort) {}

  bool null() { return add({}); }
  bool boolean(bool value) { return add(value); }
  bool number_integer(std::int64_t value) { return add(value); }
  bool number_unsigned(std::uint64_t value) { return add(value); }
  bool number_float(double value, const std::string&) { return add(value); }
  bool string(std::string& value) { return add(std::move(value)); }
  bool binary(nlohmann::json::binary_t&) { return false; }
  bool key(std::string& value) {
    keys_.push_back(std::move(value));
    return true;
  }
  bool start_object(std::size_t) { return open(); }
  bool start_array(std::size_t) { return open(); }
  bool end_object() {
    const Opened opened = close();
    auto keys = taken(keys_, opened.keys);
    return add(Builder::object(std::move(keys), taken(values_, opened.values), sort_));
  }
  bool end_array() { return add(Builder::array(taken(values_, close().values))); }
  template <class Exception>
  bool parse_error(std::size_t position, const std::string&, const Exception& exception) {
    constexpr int kNumberOverflow = 406;
    error_.kind = exception.id == kNumberOverflow ? ParseError::Kind::kRange : ParseError::Kind::kSyntax;
    error_.byte = position > 0 ? position - 1 : 0;
    error_.reason = reason(exception.what());
    return false;
  }

  tl::expected<Value, ParseError> result(bool parsed) {
    if (!parsed) return tl::unexpected(std::move(error_));
    return std::move(values_.front());
  }

 private:
  struct Opened {
    std::size_t keys, values;  // that were on the stacks before
  };

  bool add(Value value) {
    values_.push_back(std::move(value));
    return true;
  }

  bool open() {
    opened_.push_back({keys_.size(), values_.size()});
    return true;
  }

  Opened close() {
    const Opened last = opened_.back();
    opened_.pop_back();
    return last;
  }

  /// Removes the elements of a stack from `first` on.
  template <class T>
  static std::vector<T> taken(std::vector<T>& stack, std::size_t first) {
    const auto from = stack.begin() + std::ptrdiff_t(first);
    std::vector<T> top(std::make_move_iterator(from), std::make_move_iterator(stack.end()));
    stack.erase(from, stack.end());
    return top;
  }

  /// The message without nlohmann's prefix: "[json.exception.parse_error.101] parse error at line 1, column 2: " …
  static std::string reason(const std::string& what) {
    const std::size_t column = what.find("column ");
    const std::size_t colon = column == std::string::npos ? what.find("] ") : what.find(": ", column);
    return colon == std::string::npos ? what : what.substr(colon + 2);
  }

  bool sort_;
  std::vector<std::string> keys_;
  std::vector<Value> values_;
  std::vector<Opened> opened_;
  ParseError error_;
};

}  // namespace

tl::expected<Value, ParseError> parse(std::string_view text, const ParseOptions& options) {
  if (const auto byte = too_deep(text, options.max_depth))
    return tl::unexpected(
        ParseError{ParseError::Kind::kDepth, *byte,
                   "expected at most " + std::to_string(options.max_depth) + " nested arrays and objects"});
  Reader reader(options.sort);
  return reader.result(nlohmann::json::sax_parse(text.begin(), text.end(), &reader));
}

// --- writing ---------------------------------------------------------------------------------------------------------

class Writer {
 public:
  explicit Writer(int indent) : indent_(indent) {}

  void write(const Value& value, int depth = 0) {
    using Kind = Value::Kind;
    switch (value.kind_) {
      case Kind::kNull:
        text_ += "null";
        break;
      case Kind::kBoolean:
        text_ += value.content_.boolean ? "true" : "false";
        break;
      case Kind::kInteger:
        text_ += std::to_string(value.content_.integer);
        break;
      case Kind::kUnsigned:
        text_ += std::to_string(value.content_.natural);
        break;
      case Kind::kDouble:
        text_ += nlohmann::json(value.content_.number).dump();
        break;
      case Kind::kString:
        write(*value.content_.string);
        break;
      case Kind::kArray:
        write_all(value, nullptr, "[]", depth);
        break;
      case Kind::kObject:
        write_all(value, value.content_.object->keys.data(), "{}", depth);
        break;
    }
  }

  std::string text() && { return std::move(text_); }

 private:
  void write(const std::string& text) {
    const auto is_plain = [](char c) { return c >= ' ' && c <= '~' && c != '"' && c != '\\'; };
    if (std::all_of(text.begin(), text.end(), is_plain))  // most texts need no formatting
      text_.append(1, '"').append(text).append(1, '"');
    else
      text_ += nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  }

  void write_all(const Value& parent, const std::string* key, const char* brackets, int depth) {
    text_ += brackets[0];
    bool first = true;
    for (const Value& child : parent) {
      if (!first) text_ += ',';
      first = false;
      new_line(depth + 1);
      if (key) {
        write(*key++);
        text_ += indent_ < 0 ? ":" : ": ";
      }
      write(child, depth + 1);
    }
    if (!first) new_line(depth);
    text_ += brackets[1];
  }

  void new_line(int depth) {
    if (indent_ >= 0) text_.append(1, '\n').append(std::size_t(indent_ * depth), ' ');
  }

  int indent_;
  std::string text_;
};

std::string Value::dump(int indent) const {
  Writer writer(indent);
  writer.write(*this);
  return std::move(writer).text();
}

std::ostream& Value::print(std::ostream& out, const Value& value) {
  return out << value.dump();
}

}  // namespace sightline::json
