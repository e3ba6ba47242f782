// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

// The same tree as nested JSON objects. JSON keeps no lines, so that only errors of the grammar have one.

#include "scene_tree.h"

#include <dovetail/scene/user_error.h>

#include <nlohmann/json.hpp>

#include <deal.II/base/utilities.h>

#include <set>

namespace dovetail {

namespace {

/// Called by nlohmann::json for each token, which shows duplicate keys that a finished document has lost.
class JsonReader : public nlohmann::json_sax<nlohmann::json>
{
public:
  explicit JsonReader(SceneTree &tree) : tree(tree), location(tree.location_of("")) {}

  bool string(string_t &value) override { return set(value); }
  bool boolean(bool value) override { return set(value ? "true" : "false"); }
  bool number_integer(number_integer_t value) override { return set(std::to_string(value)); }
  bool number_unsigned(number_unsigned_t value) override { return set(std::to_string(value)); }
  bool number_float(number_float_t, const string_t &text) override { return set(text); }
  bool null() override { fail("null is no value; leave the entry out."); }
  bool binary(binary_t &) override { fail("binary data are no value."); }
  bool start_array(std::size_t) override
  {
    fail("arrays are not understood; write a list as one string, \"a, b, c\", a vector as \"1; 0\".");
  }
  bool end_array() override { return true; }

  bool start_object(std::size_t) override
  {
    if (names.size() > 0) {
      check_writable(key_name, "", location);
      path = join_path(path, key_name);
      check_depth(path, location);
      tree.open(path, location);
    }
    names.emplace_back();
    return true;
  }

  bool end_object() override
  {
    names.pop_back();
    path = parent_path(path);
    return true;
  }

  bool key(string_t &name) override
  {
    key_name = tidy_name(name);
    if (!names.back().insert(key_name).second)
      fail("the name stands twice in the same object. Remove one.");
    return true;
  }

  bool parse_error(std::size_t, const std::string &, const nlohmann::json::exception &error) override
  {
    const std::string text = error.what(); // "[json.exception.parse_error.101] parse error at line 3, ..."
    throw UserError(location.text() + ": " + text.substr(text.find("] ") + 2) + ".");
  }

private:
  bool set(const std::string &value)
  {
    if (names.empty())
      fail("a scene is an object: { \"Dimension\": \"2\", … }.");
    const std::string trimmed = dealii::Utilities::trim(value);
    check_writable(key_name, trimmed, location);
    tree.set(path, {key_name, trimmed, location});
    return true;
  }

  [[noreturn]] void fail(const std::string &message) const
  {
    const std::string name = join_path(path, key_name);
    throw UserError(location.text() + (name.empty() ? "" : ", '" + name + "'") + ": " + message);
  }

  SceneTree &tree;
  const Location location;
  std::string path, key_name;
  std::vector<std::set<std::string>> names; ///< keys seen so far in each open object
};

} // namespace

SceneTree parse_json(const std::string &file, const FileTexts &texts)
{
  SceneTree tree(file);
  JsonReader reader(tree);
  nlohmann::json::sax_parse(texts.texts.at(file), &reader);
  return tree;
}

} // namespace dovetail
