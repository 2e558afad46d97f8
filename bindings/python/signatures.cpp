#include "sightline/bindings/python/signatures.h"

#include <cstdlib>
#include <cstring>
#include <optional>

namespace sightline::python {
namespace {

constexpr std::string_view kEnd = "\n--\n\n";  // between a signature and its docstring, for Python

/// Finds the end of an expression of Python: a comma, "=" or closing parenthesis that is in no bracket and no text.
std::size_t end_of_part(std::string_view text, std::size_t from, std::string_view ends) {
  int depth = 0;
  char quote = '\0';
  for (std::size_t i = from; i < text.size(); ++i) {
    const char c = text[i];
    if (quote) {
      if (c == '\\')
        ++i;
      else if (c == quote)
        quote = '\0';
    } else if (c == '\'' || c == '"') {
      quote = c;
    } else if (depth == 0 && ends.find(c) != std::string_view::npos) {
      return i;
    } else if (c == '(' || c == '[' || c == '{') {
      ++depth;
    } else if (c == ')' || c == ']' || c == '}') {
      --depth;
    }
  }
  return std::string_view::npos;
}

/// A default as a literal: Python reads no names in signatures.
std::string literal(std::string_view value) {
  if (value == "inf") return "1e999";
  if (value == "Ellipsis") return "...";
  return std::string(value);
}

/// "name: type = default" without the type.
std::string argument_of(std::string_view part) {
  const std::size_t colon = part.find(':');
  if (colon == std::string_view::npos) return std::string(part);
  const std::size_t equals = end_of_part(part, colon, "=");
  std::string argument(part.substr(0, colon));
  if (equals != std::string_view::npos) argument += "=" + literal(part.substr(equals + 2));
  return argument;
}

/// "(self, view)" of a docstring of pybind11's, which begins with the function's name.
std::optional<std::string> arguments_of(std::string_view doc) {
  const std::size_t open = doc.find('(');
  if (open == std::string_view::npos) return std::nullopt;
  std::string arguments = "(";
  bool unnamed = false;  // the last one: such arguments have no name in calls
  for (std::size_t at = open + 1; doc[at] != ')';) {
    const std::size_t end = end_of_part(doc, at, ",)");
    if (end == std::string_view::npos) return std::nullopt;
    const std::string argument = argument_of(doc.substr(at, end - at));
    const bool is_unnamed =
        argument.rfind("arg", 0) == 0 && argument.find_first_not_of("0123456789", 3) == argument.npos;
    if (unnamed && !is_unnamed) arguments += "/, ";
    unnamed = is_unnamed;
    arguments += argument;
    at = doc[end] == ',' ? end + 2 : end;
    if (doc[end] == ',') arguments += ", ";
  }
  return arguments + (unnamed ? ", /)" : ")");
}

/// The docstring with the signature before it; nothing where pybind11 has written none.
std::optional<std::string> with_signature(const char* doc, const std::string& name) {
  if (!doc || std::string_view(doc).rfind(name + "(", 0) != 0 || std::strstr(doc, kEnd.data())) return std::nullopt;
  const auto arguments = arguments_of(doc);
  if (!arguments) return std::nullopt;
  return name + *arguments + std::string(kEnd) + doc;
}

/// pybind11 has allocated the docstring, and frees it with the function.
void tell_function(PyObject* function) {
  PyMethodDef* method = reinterpret_cast<PyCFunctionObject*>(function)->m_ml;
  const auto doc = with_signature(method->ml_doc, method->ml_name);
  if (!doc) return;
  char* copy = strdup(doc->c_str());
  if (!copy) return;
  std::free(const_cast<char*>(method->ml_doc));
  method->ml_doc = copy;
}

/// The compiled function of a class's attribute; null for others.
PyObject* function_of(PyObject* attribute) {
  if (PyInstanceMethod_Check(attribute)) attribute = PyInstanceMethod_GET_FUNCTION(attribute);
  return PyCFunction_Check(attribute) ? attribute : nullptr;
}

/// Python looks for a constructor's signature in what the type says of itself, where __doc__ has been taken from.
void tell_constructor(PyTypeObject* type, PyObject* init) {
  const char* doc = reinterpret_cast<PyCFunctionObject*>(init)->m_ml->ml_doc;
  const auto arguments = doc ? arguments_of(doc) : std::nullopt;
  if (!arguments) return;
  const std::string_view full = type->tp_name, name = full.substr(full.rfind('.') + 1);
  std::string text(name);
  if (arguments->rfind("(self", 0) == 0)
    text += "(" + arguments->substr(arguments->rfind("(self, ", 0) == 0 ? 7 : 5);
  else
    text += *arguments;
  text += std::string(kEnd) + (type->tp_doc ? type->tp_doc : "");
  auto* copy = static_cast<char*>(PyObject_Malloc(text.size() + 1));
  if (!copy) return;
  std::memcpy(copy, text.c_str(), text.size() + 1);
  PyObject_Free(const_cast<char*>(type->tp_doc));
  type->tp_doc = copy;
}

void tell_class(PyTypeObject* type) {
  const auto members = py::reinterpret_borrow<py::dict>(type->tp_dict);
  for (const auto& [name, value] : members) {
    py::object attribute = py::reinterpret_borrow<py::object>(value);
    if (py::isinstance<py::staticmethod>(attribute)) attribute = attribute.attr("__func__");
    PyObject* function = function_of(attribute.ptr());
    if (!function) continue;
    if (std::string(py::str(name)) == "__init__") tell_constructor(type, function);
    tell_function(function);
  }
}

}  // namespace

void tell_signatures(const py::module_& m) {
  for (const auto& [name, value] : py::cast<py::dict>(m.attr("__dict__"))) {
    if (PyCFunction_Check(value.ptr()))
      tell_function(value.ptr());
    else if (PyType_Check(value.ptr()) && py::hasattr(value, "__init__") && !PyExceptionClass_Check(value.ptr()))
      tell_class(reinterpret_cast<PyTypeObject*>(value.ptr()));
  }
}

}  // namespace sightline::python
