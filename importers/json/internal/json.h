// JSON values: parsed from text, built in code, written as text. nlohmann-json does the parsing and formats numbers and
// strings, behind this header: including nlohmann's own takes a compiler three to four seconds.
//
// Objects keep the order in which their keys were added. sorted() gives a value whose objects have ascending keys,
// which is how files are written that programs compare. Looking up a key takes logarithmic time where keys ascend, and
// linear time otherwise.
#pragma once

#include <array>
#include <compare>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <iosfwd>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <tl/expected.hpp>

namespace sightline::json {

/// Thrown by accessors when a value is not what the caller takes it for. Code that reads what others wrote asks first
/// (is_string() and so on), or catches it.
class TypeError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A value in 16 bytes: null, a boolean, an integer of 64 bits, a double, a string, an array or an object.
class Value {
  enum class Kind : std::uint8_t { kNull, kBoolean, kInteger, kUnsigned, kDouble, kString, kArray, kObject };
  struct Element;
  struct Object;
  using Array = std::vector<Value>;
  union Content {
    bool boolean;
    std::int64_t integer;
    std::uint64_t natural;
    double number;
    std::string* string;
    Array* array;
    Object* object;
  };

 public:
  struct Item {
    const std::string& key;
    const Value& value;
  };
  class Items;

  // --- construction --------------------------------------------------------------------------------------------------

  Value() = default;
  Value(std::nullptr_t) {}
  template <std::same_as<bool> T>
  Value(T value) : kind_(Kind::kBoolean), content_{.boolean = value} {}
  template <std::signed_integral T>
  Value(T value) : kind_(Kind::kInteger), content_{.integer = value} {}
  template <std::unsigned_integral T>
  requires(!std::same_as<T, bool>) Value(T value) : kind_(Kind::kUnsigned), content_{.natural = value} {}
  template <std::floating_point T>
  Value(T value) : kind_(Kind::kDouble), content_{.number = static_cast<double>(value)} {}
  Value(std::string text);
  Value(std::string_view text) : Value(std::string(text)) {}
  Value(const char* text) : Value(std::string(text)) {}
  template <class T>
  Value(const std::vector<T>& elements) : Value(array()) {
    for (const auto& element : elements) push_back(element);
  }
  template <class T, std::size_t n>
  Value(const std::array<T, n>& elements) : Value(array()) {
    for (const T& element : elements) push_back(element);
  }
  /// An object if every element is an array of a string and a value; otherwise an array.
  Value(std::initializer_list<Element> elements);
  Value(const Value& other);
  Value(Value&& other) noexcept : kind_(other.kind_), content_(other.content_) { other.kind_ = Kind::kNull; }
  Value& operator=(Value other) noexcept {
    swap(other);
    return *this;
  }
  ~Value() {
    if (kind_ >= Kind::kString) destroy();
  }
  void swap(Value& other) noexcept {
    std::swap(kind_, other.kind_);
    std::swap(content_, other.content_);
  }

  static Value array();
  static Value array(std::initializer_list<Element> elements);
  static Value object();

  // --- what it is ----------------------------------------------------------------------------------------------------

  bool is_null() const { return kind_ == Kind::kNull; }
  bool is_boolean() const { return kind_ == Kind::kBoolean; }
  bool is_number() const { return kind_ >= Kind::kInteger && kind_ <= Kind::kDouble; }
  bool is_number_integer() const { return kind_ == Kind::kInteger || kind_ == Kind::kUnsigned; }
  /// An integer of an unsigned type, or a parsed one without a sign.
  bool is_number_unsigned() const { return kind_ == Kind::kUnsigned; }
  bool is_number_float() const { return kind_ == Kind::kDouble; }
  bool is_string() const { return kind_ == Kind::kString; }
  bool is_array() const { return kind_ == Kind::kArray; }
  bool is_object() const { return kind_ == Kind::kObject; }
  /// "null", "boolean", "number", "string", "array" or "object".
  const char* type_name() const;

  // --- scalars -------------------------------------------------------------------------------------------------------

  /// A boolean, a number (converted like static_cast does), a string, or a vector of these.
  template <class T>
  T get() const {
    if constexpr (std::same_as<T, bool>) {
      return boolean();
    } else if constexpr (std::is_arithmetic_v<T>) {
      switch (kind_) {
        case Kind::kInteger:
          return static_cast<T>(content_.integer);
        case Kind::kUnsigned:
          return static_cast<T>(content_.natural);
        case Kind::kDouble:
          return static_cast<T>(content_.number);
        default:
          refuse("a number");
      }
    } else if constexpr (std::constructible_from<T, const std::string&>) {
      return T(string());
    } else {
      T elements;
      for (const Value& element : checked_array()) elements.push_back(element.get<typename T::value_type>());
      return elements;
    }
  }
  template <class T>
  void get_to(T& value) const {
    value = get<T>();
  }
  template <class T, std::size_t n>
  void get_to(std::array<T, n>& values) const {
    for (std::size_t i = 0; i < n; ++i) values[i] = at(i).get<T>();
  }
  const std::string& string() const;

  // --- arrays and objects --------------------------------------------------------------------------------------------

  /// Elements of an array or members of an object; 0 for null, 1 for other values.
  std::size_t size() const { return std::size_t(end() - begin()); }
  bool empty() const { return begin() == end(); }
  /// The elements of an array, the values of an object, nothing for null, other values themselves.
  const Value* begin() const { return range().first; }
  const Value* end() const { return range().second; }
  Value* begin() { return const_cast<Value*>(range().first); }
  Value* end() { return const_cast<Value*>(range().second); }
  const Value& front() const { return at(std::size_t{0}); }
  const Value& back() const { return at(size() - 1); }

  const Value& at(std::size_t index) const;
  const Value& at(std::string_view key) const;
  Value& at(std::size_t index) { return const_cast<Value&>(std::as_const(*this).at(index)); }
  Value& at(std::string_view key) { return const_cast<Value&>(std::as_const(*this).at(key)); }
  template <std::integral T>
  const Value& operator[](T index) const {
    return at(std::size_t(index));
  }
  template <std::integral T>
  Value& operator[](T index) {
    return at(std::size_t(index));
  }
  const Value& operator[](std::string_view key) const { return at(key); }
  /// Adds a missing key; makes null an object.
  Value& operator[](std::string_view key);
  const Value& operator[](const char* key) const { return at(std::string_view(key)); }
  Value& operator[](const char* key) { return (*this)[std::string_view(key)]; }

  /// end() where the key is missing or this is no object.
  const Value* find(std::string_view key) const;
  bool contains(std::string_view key) const;
  /// The member under a key, or `fallback` where it is missing.
  template <class T>
  T value(std::string_view key, const T& fallback) const {
    const Value* found = find_member(key);
    return found ? found->get<T>() : fallback;
  }
  Value value(std::string_view key, const Value& fallback) const {
    const Value* found = find_member(key);
    return found ? *found : fallback;
  }
  /// The members of an object, as `for (const auto& [key, value] : json.items())`.
  Items items() const;

  /// Makes null an array.
  void push_back(Value element);
  /// Sets the members of another object; makes null an object.
  void update(const Value& members);
  void erase(std::string_view key);
  void erase(std::size_t index);

  /// The value that a JSON pointer (RFC 6901) names, or null.
  const Value* find_pointer(std::string_view pointer) const;

  // --- text ----------------------------------------------------------------------------------------------------------

  /// On one line if `indent` is negative. Invalid UTF-8 is replaced by U+FFFD; NaN and infinities become null.
  std::string dump(int indent = -1) const;

  /// Objects are equal whatever the order of their keys; numbers, whatever their types.
  friend bool operator==(const Value& a, const Value& b) { return equal(a, b); }
  /// Numbers by their value and strings by their bytes; other pairs are unordered.
  friend std::partial_ordering operator<=>(const Value& a, const Value& b) { return order(a, b); }
  friend std::ostream& operator<<(std::ostream& out, const Value& value) { return print(out, value); }

 private:
  friend class Builder;
  friend class Writer;
  friend Value sorted(Value value);

  bool boolean() const;
  const Array& checked_array() const;
  const Value* find_member(std::string_view key) const;
  std::pair<const Value*, const Value*> range() const;
  void destroy() noexcept;
  [[noreturn]] void refuse(const char* expected) const;
  static bool equal(const Value& a, const Value& b);
  static std::partial_ordering order(const Value& a, const Value& b);
  static std::ostream& print(std::ostream& out, const Value& value);

  Kind kind_ = Kind::kNull;
  Content content_ = {.integer = 0};
};
static_assert(sizeof(Value) == 16);

/// Element of a list in braces: a value that can be moved out of it.
struct Value::Element {
  Element() = default;  // {} is null
  template <class T>
  requires std::convertible_to<T, Value> Element(T&& from) : value(std::forward<T>(from)) {}
  Element(std::initializer_list<Element> elements) : value(elements) {}
  mutable Value value;
};

class Value::Items {
 public:
  class Iterator {
   public:
    Iterator(const std::string* key, const Value* value) : key_(key), value_(value) {}
    Item operator*() const { return {*key_, *value_}; }
    Iterator& operator++() {
      ++key_, ++value_;
      return *this;
    }
    bool operator==(const Iterator& other) const { return value_ == other.value_; }

   private:
    const std::string* key_;
    const Value* value_;
  };
  Items(const std::string* keys, const Value* begin, const Value* end) : keys_(keys), begin_(begin), end_(end) {}
  Iterator begin() const { return {keys_, begin_}; }
  Iterator end() const { return {nullptr, end_}; }

 private:
  const std::string* keys_;
  const Value *begin_, *end_;
};

/// The value with ascending keys in all of its objects.
Value sorted(Value value);

struct ParseError {
  enum class Kind : std::uint8_t { kSyntax, kRange, kDepth };
  Kind kind = Kind::kSyntax;
  std::size_t byte = 0;  ///< offset of what is wrong; unknown for kRange
  std::string reason;
};

inline constexpr int kAnyDepth = std::numeric_limits<int>::max();

struct ParseOptions {
  bool sort = false;          ///< ascending keys in all objects
  int max_depth = kAnyDepth;  ///< of nested arrays and objects; checked before a value is made
};

/// Parses a whole text. Of members with the same key the last one counts. A number beyond a double's range is an error.
tl::expected<Value, ParseError> parse(std::string_view text, const ParseOptions& options = {});

}  // namespace sightline::json
