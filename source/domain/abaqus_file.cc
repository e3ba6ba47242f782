// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Abaqus' .inp: the keywords *NODE, *ELEMENT, *ELSET, *SURFACE and *SOLID SECTION (Abaqus keywords reference
// guide); all others are passed over. Ids are numbers in names: *ELEMENT, ELSET=EB3 or *SOLID SECTION,
// ELSET=…, MATERIAL=steel-3 give the material id 3, *SURFACE, NAME=SS3 the boundary id 3.

#include <dovetail/domain/mesh_text.h>

#include <algorithm>
#include <map>
#include <unordered_map>

namespace dovetail {

namespace {

using Numbers = std::vector<std::int64_t>;

/// The keyword of a line and its parameters, without blanks, in capitals.
struct Keyword
{
  std::string name;
  std::map<std::string, std::string> parameters;
};

class AbaqusReader
{
public:
  AbaqusReader(MeshText &text, const unsigned int dim) : text(text), collector(text, dim), dim(dim) {}

  MeshFile read()
  {
    next_line();
    while (has_line) {
      const Keyword keyword = read_keyword();
      next_line();
      if (keyword.name == "*NODE")
        read_nodes();
      else if (keyword.name == "*ELEMENT")
        read_elements(keyword);
      else if (keyword.name == "*ELSET")
        read_set(keyword);
      else if (keyword.name == "*SURFACE")
        read_surface(keyword);
      else if (keyword.name == "*SOLIDSECTION")
        read_section(keyword);
      else
        while (is_data())
          next_line();
    }
    for (const Cell &cell : cells)
      collector.add_element(cell.number, dim, cell.id, cell.nodes);
    return collector.finish();
  }

private:
  /// The next line that is no comment.
  void next_line()
  {
    do {
      has_line = !text.at_end();
      line = std::string(text.rest_of_line());
      line.erase(std::remove_if(line.begin(), line.end(),
                                [](const char c) { return c == ' ' || c == '\t' || c == '\r'; }),
                 line.end());
      std::transform(line.begin(), line.end(), line.begin(),
                     [](const char c) { return c >= 'a' && c <= 'z' ? char(c - 'a' + 'A') : c; });
    } while (has_line && (line.empty() || line.substr(0, 2) == "**"));
  }

  bool is_data() const { return has_line && line[0] != '*'; }

  std::vector<std::string> words_of_line() const
  {
    std::vector<std::string> words;
    std::size_t begin = 0;
    for (std::size_t end; (end = line.find(',', begin)) != std::string::npos; begin = end + 1)
      words.push_back(line.substr(begin, end - begin));
    if (begin < line.size()) // nothing after a last comma
      words.push_back(line.substr(begin));
    return words;
  }

  Keyword read_keyword() const
  {
    text.check(line[0] == '*', "expected a keyword, '*…'");
    const auto words = words_of_line();
    Keyword keyword = {words[0], {}};
    for (std::size_t i = 1; i < words.size(); ++i) {
      const auto equals = words[i].find('=');
      keyword.parameters[words[i].substr(0, equals)] =
          equals == std::string::npos ? "" : words[i].substr(equals + 1);
    }
    return keyword;
  }

  /// The digits in a name, 0 if there are none.
  std::int64_t id_in(const std::string &name) const
  {
    std::string digits;
    for (const char letter : name)
      if (letter >= '0' && letter <= '9')
        digits += letter;
    return digits.empty() ? 0 : text.to_integer(digits, "an id in the name " + name, 0, largest_mesh_id);
  }

  std::int64_t number_of(const std::string &word, const std::string &what) const
  {
    return text.to_integer(word, what, 1, largest_mesh_number);
  }

  void read_nodes()
  {
    for (; is_data(); next_line()) {
      const auto words = words_of_line();
      text.check(words.size() > dim, "a node needs a number and " + std::to_string(dim) + " coordinates");
      dealii::Point<3> position;
      for (unsigned int d = 0; d < 3 && d + 1 < words.size(); ++d)
        position[d] = text.to_number(words[d + 1], "a coordinate of the node " + words[0]);
      collector.add_node(number_of(words[0], "the number of a node"), position);
    }
  }

  /// Number and nodes of an element, which a comma at the end of a line continues.
  Numbers read_numbers_of_element()
  {
    Numbers numbers;
    while (true) {
      for (const std::string &word : words_of_line())
        numbers.push_back(number_of(word, "a number of an element or a node"));
      const bool goes_on = line.back() == ',';
      next_line();
      if (!goes_on || !is_data())
        return numbers;
    }
  }

  void read_elements(const Keyword &keyword)
  {
    const auto type = keyword.parameters.find("TYPE");
    const std::string type_name = type == keyword.parameters.end() ? "" : type->second;
    const auto set = keyword.parameters.find("ELSET");
    const std::string set_name = set == keyword.parameters.end() ? "" : set->second;
    while (is_data()) {
      const Numbers numbers = read_numbers_of_element();
      if (is_cell(numbers.size() - 1, numbers[0], type_name))
        add_cell(numbers, set_name);
    }
  }

  /// Bars, and in 3D shells, are none; solids are called C3D… or DC3D….
  bool is_cell(const std::size_t n_nodes, const std::int64_t number, const std::string &type_name) const
  {
    const bool is_solid = type_name.find("C3D") != std::string::npos;
    const std::string element = "the element " + std::to_string(number) + " of type " + type_name;
    text.check(dim == 3 || !is_solid, element + " has three dimensions, but the scene has Dimension = 2");
    if (n_nodes <= 2 || (dim == 3 && !is_solid && !type_name.empty()))
      return false;
    text.check(n_nodes == dim + 1 || n_nodes == (1u << dim),
               element + " has " + std::to_string(n_nodes) +
                   " nodes. Elements of first order are read: triangles and quadrilaterals (3 and 4 nodes), "
                   "tetrahedra and hexahedra (4 and 8)");
    return true;
  }

  void add_cell(const Numbers &numbers, const std::string &set_name)
  {
    Cell cell;
    cell.number = numbers[0];
    cell.id = set_name.substr(0, 2) == "EB" ? id_in(set_name) : 0;
    for (std::size_t i = 1; i < numbers.size(); ++i)
      cell.nodes.push_back(collector.node(numbers[i]));
    text.check(index.emplace(cell.number, cells.size()).second,
               "the element " + std::to_string(cell.number) + " is given a second time");
    if (!set_name.empty())
      sets[set_name].push_back(cell.number);
    cells.push_back(cell);
  }

  void read_set(const Keyword &keyword)
  {
    const auto name = keyword.parameters.find("ELSET");
    text.check(name != keyword.parameters.end(), "*ELSET needs a name, ELSET=…");
    Numbers &set = sets[name->second];
    for (; is_data(); next_line()) {
      const auto words = words_of_line();
      if (keyword.parameters.count("GENERATE") > 0)
        generate(words, set);
      else
        for (const std::string &word : words)
          if (const auto other = sets.find(word); other != sets.end()) {
            const Numbers other_numbers = other->second;
            set.insert(set.end(), other_numbers.begin(), other_numbers.end());
            text.check(set.size() <= 16 * (cells.size() + 1), "the set has more elements than the file");
          } else
            set.push_back(number_of(word, "the number of an element or the name of a set"));
    }
  }

  /// first, last [, step]
  void generate(const std::vector<std::string> &words, Numbers &set) const
  {
    text.check(words.size() == 2 || words.size() == 3, "GENERATE needs 'first, last, step'");
    const auto first = number_of(words[0], "the first element of a set");
    const auto last = number_of(words[1], "the last element of a set");
    const auto step = words.size() == 3 ? number_of(words[2], "a step") : 1;
    text.check(first <= last && (last - first) / step < std::int64_t(cells.size()),
               "the set has more elements than the file, or its last is before its first");
    for (auto number = first; number <= last; number += step)
      set.push_back(number);
  }

  const Numbers *find_set(const std::string &name) const
  {
    const auto found = sets.find(name);
    return found == sets.end() ? nullptr : &found->second;
  }

  std::size_t find_cell(const std::int64_t number) const
  {
    const auto found = index.find(number);
    text.check(found != index.end(), "the element " + std::to_string(number) + " does not exist");
    return found->second;
  }

  void read_surface(const Keyword &keyword)
  {
    const auto name = keyword.parameters.find("NAME");
    text.check(name != keyword.parameters.end(), "*SURFACE needs a name, NAME=…");
    const auto type = keyword.parameters.find("TYPE");
    const bool has_faces = type == keyword.parameters.end() || type->second == "ELEMENT";
    for (; is_data(); next_line()) {
      if (!has_faces) // of nodes
        continue;
      const auto words = words_of_line();
      text.check(words.size() == 2 && words[1].size() == 2 && (words[1][0] == 'S' || words[1][0] == 'E'),
                 "a surface needs lines 'element or set, S1'");
      const unsigned int face = words[1][1] - '0';
      if (const Numbers *set = find_set(words[0]))
        for (const auto number : *set)
          add_face(number, face, id_in(name->second));
      else
        add_face(number_of(words[0], "the number of an element or the name of a set"), face,
                 id_in(name->second));
    }
  }

  void add_face(const std::int64_t number, const unsigned int face, const unsigned int id)
  {
    /// Nodes of Abaqus' faces S1, S2, …
    static const std::map<std::size_t, std::vector<std::vector<unsigned int>>> faces_of_solid = {
        {4, {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}}},
        {8, {{0, 1, 2, 3}, {4, 7, 6, 5}, {0, 4, 5, 1}, {1, 5, 6, 2}, {2, 6, 7, 3}, {3, 7, 4, 0}}}};
    const auto &nodes = cells[find_cell(number)].nodes;
    const std::size_t n_faces = dim == 2 ? nodes.size() : faces_of_solid.at(nodes.size()).size();
    text.check(face >= 1 && face <= n_faces,
               "the element " + std::to_string(number) + " has no face " + std::to_string(face));
    std::vector<unsigned int> nodes_of_face;
    if (dim == 2)
      nodes_of_face = {nodes[face - 1], nodes[face % nodes.size()]};
    else
      for (const unsigned int i : faces_of_solid.at(nodes.size())[face - 1])
        nodes_of_face.push_back(nodes[i]);
    collector.add_element(number, dim - 1, id, nodes_of_face);
  }

  void read_section(const Keyword &keyword)
  {
    const auto set = keyword.parameters.find("ELSET"), material = keyword.parameters.find("MATERIAL");
    if (set != keyword.parameters.end() && material != keyword.parameters.end())
      if (const auto dash = material->second.rfind('-'); dash != std::string::npos)
        if (const Numbers *numbers = find_set(set->second))
          for (const auto number : *numbers)
            cells[find_cell(number)].id = id_in(material->second.substr(dash));
    while (is_data())
      next_line();
  }

  struct Cell
  {
    std::int64_t number = 0;
    unsigned int id = 0;
    std::vector<unsigned int> nodes;
  };

  MeshText &text;
  MeshCollector collector;
  const unsigned int dim;
  std::string line;
  bool has_line = false;
  std::vector<Cell> cells;
  std::unordered_map<std::int64_t, std::size_t> index;
  std::map<std::string, Numbers> sets;
};

} // namespace

MeshFile read_abaqus(MeshText &text, const unsigned int dim)
{
  return AbaqusReader(text, dim).read();
}

} // namespace dovetail
