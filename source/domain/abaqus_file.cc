// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Abaqus' .inp: nodes, elements, sets, surfaces and sections of a flat file or of parts and their instances
// in an assembly (Abaqus keywords reference guide); keywords that are no mesh are passed over. Sets of
// elements, instances, parts and materials name volumes; surfaces, sets of nodes and sets of shells or bars
// on faces of cells (as Gmsh writes its physical groups) name boundaries. An id in digits is taken from
// names: *ELEMENT, ELSET=EB3 or *SOLID SECTION, ELSET=..., MATERIAL=steel-3 give the material id 3, *SURFACE,
// NAME=SS3 the boundary id 3.

#include <dovetail/domain/mesh_text.h>

#include <boost/algorithm/string/case_conv.hpp>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <set>
#include <sstream>
#include <unordered_map>

namespace dovetail {

namespace {

/// The digits in a name.
std::string digits_in(const std::string &name)
{
  std::string digits;
  for (const char letter : name)
    if (letter >= '0' && letter <= '9')
      digits += letter;
  return digits;
}

/// The keyword of a line and its parameters, without blanks, the names in capitals.
struct AbaqusKeyword
{
  std::string name;
  std::map<std::string, std::string> parameters;

  bool has(const std::string &parameter) const { return parameters.count(parameter) > 0; }
  std::string operator[](const std::string &parameter) const
  {
    return has(parameter) ? parameters.at(parameter) : "";
  }
};

/// Numbers of nodes or elements by the instance that has them; "" is the part, or a file without parts.
struct AbaqusSet
{
  std::string name; ///< as it is written first
  std::map<std::string, std::vector<std::int64_t>> numbers;
};

/// By the name in capitals: these do not count in Abaqus.
using AbaqusSets = std::map<std::string, AbaqusSet>;

struct AbaqusElement
{
  std::int64_t number;
  std::vector<std::int64_t> nodes; ///< none: it is no cell
  unsigned int id;                 ///< of its material
  std::vector<std::int64_t> facet; ///< the vertices of a shell or, in 2D, of a bar
};

struct AbaqusSurface
{
  std::string name;
  bool has_nodes; ///< its parts are nodes or sets of nodes
  /// An element or a set, and its face: 1, 2, ..., or 0 for all those that are free.
  std::vector<std::pair<std::string, unsigned int>> parts;
};

/// A part, an instance of one, or what stands outside of both.
struct AbaqusPart
{
  std::string name, part;
  std::vector<std::pair<std::int64_t, dealii::Point<3>>> nodes;
  std::unordered_map<std::int64_t, unsigned int> node_index;
  std::vector<AbaqusElement> elements;
  std::unordered_map<std::int64_t, std::size_t> element_index;
  AbaqusSets node_sets, element_sets;
  std::vector<AbaqusSurface> surfaces;
  std::vector<std::pair<std::string, std::string>> sections; ///< set, material
  std::vector<std::vector<double>> placement;                ///< translation; axis and angle
  std::vector<std::size_t> cells;                            ///< of the elements, in the file that is made
  std::vector<std::vector<unsigned int>> facets;             ///< of the elements, sorted, likewise
};

constexpr std::size_t no_cell = -1;

/// Numbers of vertices of Abaqus' faces S1, S2, ...
const std::map<std::pair<unsigned int, unsigned int>, std::vector<std::vector<unsigned int>>>
    faces_in_abaqus = {
        {{2, 3}, {{0, 1}, {1, 2}, {2, 0}}},
        {{2, 4}, {{0, 1}, {1, 2}, {2, 3}, {3, 0}}},
        {{3, 4}, {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}}},
        {{3, 5}, {{0, 1, 2, 3}, {0, 4, 1}, {1, 4, 2}, {2, 4, 3}, {3, 4, 0}}},
        {{3, 6}, {{0, 1, 2}, {3, 5, 4}, {0, 3, 4, 1}, {1, 4, 5, 2}, {2, 5, 3, 0}}},
        {{3, 8}, {{0, 1, 2, 3}, {4, 7, 6, 5}, {0, 4, 5, 1}, {1, 5, 6, 2}, {2, 6, 7, 3}, {3, 7, 4, 0}}}};

unsigned int n_vertices_in_abaqus(const unsigned int dim, const std::size_t n_nodes)
{
  if (dim == 2)
    return n_nodes == 3 || n_nodes == 6 ? 3 : n_nodes == 4 || n_nodes == 8 ? 4 : 0;
  static const std::map<std::size_t, unsigned int> n_vertices = {{4, 4}, {10, 4}, {5, 5}, {13, 5},
                                                                 {6, 6}, {15, 6}, {8, 8}, {20, 8}};
  const auto found = n_vertices.find(n_nodes);
  return found == n_vertices.end() ? 0 : found->second;
}

/// Trusses, beams and pipes, and shells and membranes of axisymmetric bodies, which are lines.
bool is_bar(const std::string &type)
{
  static const std::vector<std::string> beginnings = {"T2D", "T3D", "B2",  "B3",  "PIPE", "FRAME",
                                                      "R2D", "RAX", "SAX", "MAX", "DSAX"};
  return std::any_of(beginnings.begin(), beginnings.end(),
                     [&type](const std::string &beginning) { return type.rfind(beginning, 0) == 0; });
}

/// Of an element that is no cell; 0 if it is no facet of one either.
unsigned int n_vertices_of_facet(const unsigned int dim, const std::size_t n_nodes, const std::string &type)
{
  if (dim == 2)
    return n_nodes == 2 || n_nodes == 3 ? 2 : 0;
  return is_bar(type) ? 0 : n_vertices_in_abaqus(2, n_nodes);
}

/// What the lines of the file say, part by part.
class AbaqusReader
{
public:
  AbaqusReader(MeshText &text, const unsigned int dim) : outside(1), text(text), dim(dim)
  {
    next_line();
    while (has_line) {
      const AbaqusKeyword keyword = read_keyword();
      if (reads_input(keyword))
        open_input(keyword["INPUT"]);
      next_line();
      read_block(keyword);
      while (is_data())
        next_line();
    }
    text.check(current == &outside[0],
               "the file ends inside of a *PART or *INSTANCE, which needs *END PART or *END INSTANCE");
  }

  std::vector<AbaqusPart> outside, instances; ///< outside: one

private:
  /// The next line that is no comment, without blanks.
  void next_line()
  {
    do {
      while (!inputs.empty() && inputs.back()->at_end())
        inputs.pop_back();
      MeshText &from = inputs.empty() ? text : *inputs.back();
      has_line = !from.at_end();
      line = std::string(from.rest_of_line());
      line.erase(std::remove_if(line.begin(), line.end(),
                                [](const char c) { return c == ' ' || c == '\t' || c == '\r' || c == '"'; }),
                 line.end());
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

  AbaqusKeyword read_keyword()
  {
    text.check(line[0] == '*', "expected a keyword, '*…'");
    while (line.back() == ',') { // the parameters go on
      const std::string begin = line;
      next_line();
      text.check(has_line, "the file ends within a keyword");
      line = begin + line;
    }
    const auto words = words_of_line();
    AbaqusKeyword keyword = {boost::to_upper_copy(words[0]), {}};
    for (std::size_t i = 1; i < words.size(); ++i) {
      const auto equals = words[i].find('=');
      keyword.parameters[boost::to_upper_copy(words[i].substr(0, equals))] =
          equals == std::string::npos ? "" : words[i].substr(equals + 1);
    }
    return keyword;
  }

  /// Whether the lines of a keyword that is read stand in another file.
  static bool reads_input(const AbaqusKeyword &keyword)
  {
    static const std::set<std::string> names = {"*NODE", "*ELEMENT", "*NSET", "*ELSET", "*INCLUDE"};
    return keyword.has("INPUT") && names.count(keyword.name) > 0;
  }

  /// The next lines are those of a file beside this one; messages name the line of the keyword.
  void open_input(const std::string &name)
  {
    const auto path = std::filesystem::path(text.file_name()).parent_path() / name;
    std::error_code error;
    text.check(std::filesystem::is_regular_file(path, error),
               "INPUT names the file '" + name + "', which is not there: it is looked for in " +
                   (path.parent_path().empty() ? "the working directory" : path.parent_path().string()));
    text.check(inputs.size() < 100, "the file '" + name + "' includes itself");
    std::ostringstream content;
    content << std::ifstream(path, std::ios::binary).rdbuf();
    inputs.push_back(std::make_unique<MeshText>(content.str()));
  }

  void read_block(const AbaqusKeyword &keyword)
  {
    static const std::map<std::string, void (AbaqusReader::*)(const AbaqusKeyword &)> blocks = {
        {"*NODE", &AbaqusReader::read_nodes},         {"*ELEMENT", &AbaqusReader::read_elements},
        {"*NSET", &AbaqusReader::read_set_of_nodes},  {"*ELSET", &AbaqusReader::read_set_of_elements},
        {"*SURFACE", &AbaqusReader::read_surface},    {"*SOLIDSECTION", &AbaqusReader::read_section},
        {"*PART", &AbaqusReader::begin_part},         {"*ENDPART", &AbaqusReader::end_part},
        {"*INSTANCE", &AbaqusReader::begin_instance}, {"*ENDINSTANCE", &AbaqusReader::end_part}};
    static const std::set<std::string> generators = {"*NGEN",  "*NFILL",  "*NCOPY",
                                                     "*ELGEN", "*ELCOPY", "*SYSTEM"};
    text.check(generators.count(keyword.name) == 0,
               "the keyword " + keyword.name +
                   " is not read. Write a file that holds all nodes and elements in global coordinates (in "
                   "Abaqus/CAE: Job, Write Input)");
    if (const auto block = blocks.find(keyword.name); block != blocks.end())
      (this->*block->second)(keyword);
  }

  std::int64_t number_of(const std::string &word, const std::string &what) const
  {
    return text.to_integer(word, what, 1, largest_mesh_number);
  }

  static bool is_number(const std::string &word)
  {
    return !word.empty() && word.find_first_not_of("+-0123456789") == std::string::npos;
  }

  std::string name_in(const AbaqusKeyword &keyword, const std::string &parameter) const
  {
    text.check(!keyword[parameter].empty(), keyword.name + " needs a name, " + parameter + "=…");
    return keyword[parameter];
  }

  // ---- parts

  void begin_part(const AbaqusKeyword &keyword)
  {
    text.check(current == &outside[0], "a part begins inside of another one");
    parts.emplace_back();
    parts.back().name = name_in(keyword, "NAME");
    current = &parts.back();
  }

  /// A copy of its part, to which more may be added.
  void begin_instance(const AbaqusKeyword &keyword)
  {
    text.check(current == &outside[0], "an instance begins inside of a part or an instance");
    const std::string part = boost::to_upper_copy(name_in(keyword, "PART"));
    const auto found = std::find_if(parts.begin(), parts.end(), [&](const auto &known) {
      return boost::to_upper_copy(known.name) == part;
    });
    text.check(found != parts.end(), "the part '" + keyword["PART"] + "' of an instance does not exist");
    instances.push_back(*found);
    current = &instances.back();
    current->part = found->name;
    current->name = name_in(keyword, "NAME");
    for (; is_data(); next_line()) {
      current->placement.emplace_back();
      for (const std::string &word : words_of_line())
        current->placement.back().push_back(text.to_number(word, "the position of an instance"));
    }
  }

  void end_part(const AbaqusKeyword &keyword)
  {
    text.check(current != &outside[0], keyword.name + " ends nothing");
    for (const auto &numbers : current->placement)
      text.check(numbers.size() == 3 || numbers.size() == 7,
                 "the position of the instance '" + current->name +
                     "' needs a line with three numbers and perhaps one with seven");
    current = &outside[0];
  }

  // ---- nodes and elements

  void read_nodes(const AbaqusKeyword &keyword)
  {
    const std::string system = boost::to_upper_copy(keyword["SYSTEM"]);
    text.check(!keyword.has("SYSTEM") || system == "R" || system == "C",
               "*NODE, SYSTEM=" + keyword["SYSTEM"] +
                   " is not read, only R (x, y, z) and C (r, angle in degrees, z). Write a file that holds "
                   "all nodes in global coordinates (in Abaqus/CAE: Job, Write Input)");
    for (; is_data(); next_line()) {
      const auto words = words_of_line();
      text.check(words.size() > dim, "a node needs a number and " + std::to_string(dim) + " coordinates");
      dealii::Point<3> position;
      for (unsigned int d = 0; d < 3 && d + 1 < words.size(); ++d)
        position[d] = text.to_number(words[d + 1], "a coordinate of the node " + words[0]);
      if (system == "C") {
        const double r = position[0], angle = position[1] * std::acos(-1.) / 180;
        position[0] = r * std::cos(angle);
        position[1] = r * std::sin(angle);
      }
      const auto number = number_of(words[0], "the number of a node");
      text.check(current->node_index.emplace(number, current->nodes.size()).second,
                 "the node " + std::to_string(number) + " is given a second time");
      current->nodes.emplace_back(number, position);
      if (keyword.has("NSET"))
        set_of(current->node_sets, keyword["NSET"]).numbers[""].push_back(number);
    }
  }

  static AbaqusSet &set_of(AbaqusSets &sets, const std::string &name)
  {
    AbaqusSet &set = sets[boost::to_upper_copy(name)];
    if (set.name.empty())
      set.name = name;
    return set;
  }

  /// Number and nodes of an element, which a comma at the end of a line continues.
  std::vector<std::int64_t> read_numbers_of_element()
  {
    std::vector<std::int64_t> numbers;
    while (true) {
      for (const std::string &word : words_of_line())
        numbers.push_back(number_of(word, "a number of an element or a node"));
      const bool goes_on = line.back() == ',';
      next_line();
      if (!goes_on || !is_data())
        return numbers;
    }
  }

  void read_elements(const AbaqusKeyword &keyword)
  {
    const std::string type = boost::to_upper_copy(keyword["TYPE"]), set = keyword["ELSET"];
    const bool has_id = boost::to_upper_copy(set.substr(0, 2)) == "EB";
    while (is_data()) {
      const auto numbers = read_numbers_of_element();
      AbaqusElement element = {numbers[0], {}, has_id ? id_in(set) : 0, {}};
      if (is_cell(numbers.size() - 1, numbers[0], type)) {
        element.nodes.assign(numbers.begin() + 1, numbers.end());
        check_nodes(element.nodes);
        order_as_in_gmsh(element.nodes);
      } else if (const auto n = n_vertices_of_facet(dim, numbers.size() - 1, type); n > 0) {
        element.facet.assign(numbers.begin() + 1, numbers.begin() + 1 + n);
        if (n == 2) // of three nodes of a bar the second is in the middle
          element.facet[1] = numbers.back();
        check_nodes(element.facet);
      }
      text.check(current->element_index.emplace(element.number, current->elements.size()).second,
                 "the element " + std::to_string(element.number) + " is given a second time");
      if (!set.empty())
        set_of(current->element_sets, set).numbers[""].push_back(element.number);
      current->elements.push_back(element);
    }
  }

  void check_nodes(const std::vector<std::int64_t> &nodes) const
  {
    for (const auto node : nodes)
      text.check(current->node_index.count(node) > 0, "the node " + std::to_string(node) + " does not exist");
  }

  unsigned int id_in(const std::string &name) const
  {
    const std::string digits = digits_in(name);
    return digits.empty() ? 0 : text.to_integer(digits, "an id in the name " + name, 0, largest_mesh_id);
  }

  /// Bars, and in 3D shells, are none; solids are called C3D… or DC3D….
  bool is_cell(const std::size_t n_nodes, const std::int64_t number, const std::string &type_name) const
  {
    const bool is_solid = type_name.find("C3D") != std::string::npos;
    const std::string element = "the element " + std::to_string(number) + " of type " + type_name;
    text.check(dim == 3 || !is_solid, element + " has three dimensions, but the scene has Dimension = 2");
    if (n_nodes <= 2 || is_bar(type_name) || (dim == 3 && !is_solid && !type_name.empty()))
      return false;
    const unsigned int n_vertices = n_vertices_in_abaqus(dim, n_nodes);
    const bool is_wedge_or_pyramid = dim == 3 && (n_vertices == 5 || n_vertices == 6);
    text.check(n_vertices > 0 && (!is_wedge_or_pyramid ||
                                  type_name.find("C3D" + std::to_string(n_nodes)) != std::string::npos),
               element + " has " + std::to_string(n_nodes) +
                   (dim == 2 ? " nodes. Triangles and quadrilaterals are read (3 or 6 and 4 or 8 nodes)"
                             : " nodes. Tetrahedra and hexahedra are read (4 or 10 and 8 or 20 nodes)"));
    return true;
  }

  // ---- sets

  void read_set_of_nodes(const AbaqusKeyword &keyword)
  {
    read_set(keyword, "NSET", current->node_sets, &AbaqusPart::node_sets, current->nodes.size());
  }

  void read_set_of_elements(const AbaqusKeyword &keyword)
  {
    read_set(keyword, "ELSET", current->element_sets, &AbaqusPart::element_sets, current->elements.size());
  }

  void read_set(const AbaqusKeyword &keyword, const std::string &parameter, AbaqusSets &sets,
                AbaqusSets AbaqusPart::*member, const std::size_t n_own)
  {
    AbaqusSet &set = set_of(sets, name_in(keyword, parameter));
    const std::string instance = boost::to_upper_copy(keyword["INSTANCE"]);
    const AbaqusPart *const owner = keyword.has("INSTANCE") ? find_instance(instance) : nullptr;
    const std::size_t n = owner == nullptr                   ? n_own
                          : member == &AbaqusPart::node_sets ? owner->nodes.size()
                                                             : owner->elements.size();
    if (parameter == "NSET" && keyword.has("ELSET"))
      add_nodes_of_elements(keyword["ELSET"], set);
    for (; is_data(); next_line()) {
      const auto words = words_of_line();
      if (keyword.has("GENERATE")) {
        generate(words, n, set.numbers[instance]);
        continue;
      }
      for (const std::string &word : words)
        if (!word.empty())
          add_to_set(word, instance, owner == nullptr ? sets : owner->*member, member, set);
    }
    for (auto &[name, numbers] : set.numbers) {
      std::sort(numbers.begin(), numbers.end());
      numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
    }
  }

  /// The nodes of all elements in a set of these.
  void add_nodes_of_elements(const std::string &name, AbaqusSet &set) const
  {
    AbaqusSet elements;
    add_to_set(name, "", current->element_sets, &AbaqusPart::element_sets, elements);
    for (const auto &[instance, numbers] : elements.numbers) {
      const AbaqusPart &owner = instance.empty() ? *current : *find_instance(instance);
      for (const auto number : numbers) {
        const auto found = owner.element_index.find(number);
        text.check(found != owner.element_index.end(),
                   "the element " + std::to_string(number) + " of the set '" + name + "' does not exist");
        const AbaqusElement &element = owner.elements[found->second];
        const auto &nodes = element.nodes.empty() ? element.facet : element.nodes;
        set.numbers[instance].insert(set.numbers[instance].end(), nodes.begin(), nodes.end());
      }
    }
  }

  const AbaqusPart *find_instance(const std::string &name) const
  {
    for (const AbaqusPart &instance : instances)
      if (boost::to_upper_copy(instance.name) == name)
        return &instance;
    text.fail("the instance '" + name + "' does not exist");
  }

  /// A number, the name of a set, or either after "instance.".
  void add_to_set(const std::string &word, const std::string &instance, const AbaqusSets &sets,
                  AbaqusSets AbaqusPart::*member, AbaqusSet &set) const
  {
    if (const auto dot = word.find('.'); dot != std::string::npos) {
      const std::string other = boost::to_upper_copy(word.substr(0, dot));
      add_to_set(word.substr(dot + 1), other, find_instance(other)->*member, member, set);
    } else if (is_number(word))
      set.numbers[instance].push_back(number_of(word, "a number in a set"));
    else {
      const auto known = sets.find(boost::to_upper_copy(word));
      text.check(known != sets.end(), "the set '" + word + "' does not exist");
      const auto numbers = known->second.numbers; // it may be this set
      for (const auto &[owner, its_numbers] : numbers) {
        auto &all = set.numbers[owner.empty() ? instance : owner];
        all.insert(all.end(), its_numbers.begin(), its_numbers.end());
      }
    }
  }

  /// first, last [, step]
  void generate(const std::vector<std::string> &words, const std::size_t n,
                std::vector<std::int64_t> &set) const
  {
    text.check(words.size() == 2 || words.size() == 3, "GENERATE needs 'first, last, step'");
    const auto first = number_of(words[0], "the first number of a set");
    const auto last = number_of(words[1], "the last number of a set");
    const auto step = words.size() == 3 ? number_of(words[2], "a step") : 1;
    text.check(first <= last && (last - first) / step < std::int64_t(n),
               "the set has more members than the file, or its last is before its first");
    for (auto number = first; number <= last; number += step)
      set.push_back(number);
  }

  // ---- surfaces and sections

  void read_surface(const AbaqusKeyword &keyword)
  {
    AbaqusSurface surface = {name_in(keyword, "NAME"), boost::to_upper_copy(keyword["TYPE"]) == "NODE", {}};
    const std::string type = boost::to_upper_copy(keyword["TYPE"]);
    if (!type.empty() && type != "ELEMENT" && type != "NODE")
      return; // of no mesh
    text.check(keyword["COMBINE"].empty(),
               "COMBINE is not understood. Leave this surface out, and name those that "
               "it combines where the scene asks for boundaries");
    for (; is_data(); next_line()) {
      const auto words = words_of_line();
      text.check(!words.empty() && words.size() <= 2 && !words[0].empty(),
                 "a surface needs lines 'element or set, S1'");
      const std::string face = surface.has_nodes || words.size() == 1 ? "" : boost::to_upper_copy(words[1]);
      const bool has_number = face.size() == 2 && (face[0] == 'S' || face[0] == 'E') && std::isdigit(face[1]);
      text.check(face.empty() || has_number || face == "SPOS" || face == "SNEG",
                 "a surface needs lines 'element or set, S1'");
      if (has_number)
        check_face(words[0], face[1] - '0');
      surface.parts.emplace_back(words[0], has_number ? face[1] - '0' : 0);
    }
    current->surfaces.push_back(surface);
  }

  /// Of a single element, which can be told at once.
  void check_face(const std::string &element, const unsigned int face) const
  {
    if (!is_number(element))
      return;
    const auto found = current->element_index.find(number_of(element, "the number of an element"));
    text.check(found != current->element_index.end() || current == &outside[0],
               "the element " + element + " does not exist");
    if (found == current->element_index.end())
      return;
    const auto &nodes = current->elements[found->second].nodes;
    text.check(
        nodes.empty() ||
            (face >= 1 && face <= faces_in_abaqus.at({dim, n_vertices_in_abaqus(dim, nodes.size())}).size()),
        "the element " + element + " has no face " + std::to_string(face));
  }

  void read_section(const AbaqusKeyword &keyword)
  {
    if (keyword.has("ELSET") && keyword.has("MATERIAL"))
      current->sections.emplace_back(keyword["ELSET"], keyword["MATERIAL"]);
  }

  MeshText &text;
  std::vector<std::unique_ptr<MeshText>> inputs; ///< files within the file, the innermost last
  const unsigned int dim;
  std::string line;
  bool has_line = false;
  std::vector<AbaqusPart> parts;
  AbaqusPart *current = &outside[0];
};

/// All instances in their places, with the names of their parts.
class AbaqusAssembly
{
public:
  AbaqusAssembly(MeshText &text, const unsigned int dim, AbaqusReader &reader)
      : text(text), collector(text, dim), dim(dim), parts(std::move(reader.outside))
  {
    for (AbaqusPart &instance : reader.instances)
      parts.push_back(std::move(instance));
  }

  MeshFile make()
  {
    collector.file.format = "Abaqus";
    for (AbaqusPart &part : parts)
      add_part(part);
    for (const AbaqusPart &part : parts)
      name_volumes(part);
    for (const AbaqusPart &part : parts)
      for (const AbaqusSurface &surface : part.surfaces)
        add_surface(part, surface);
    for (const AbaqusPart &part : parts)
      for (const auto &[key, set] : part.node_sets)
        add_faces_of_nodes(part, set);
    add_facets();
    add_faces();
    return collector.finish();
  }

private:
  /// A translation, then a turn about an axis through two points (Rodrigues' formula).
  static dealii::Point<3> place(const AbaqusPart &part, const dealii::Point<3> &position)
  {
    dealii::Point<3> X = position;
    for (const auto &numbers : part.placement)
      if (numbers.size() == 3)
        X += dealii::Tensor<1, 3>({numbers[0], numbers[1], numbers[2]});
      else {
        const dealii::Point<3> a(numbers[0], numbers[1], numbers[2]);
        dealii::Tensor<1, 3> axis = dealii::Point<3>(numbers[3], numbers[4], numbers[5]) - a;
        axis /= axis.norm();
        const dealii::Tensor<1, 3> r = X - a;
        const double angle = numbers[6] * std::acos(-1.) / 180;
        X = a + std::cos(angle) * r + std::sin(angle) * dealii::cross_product_3d(axis, r) +
            (1 - std::cos(angle)) * (axis * r) * axis;
      }
    return X;
  }

  void add_part(AbaqusPart &part)
  {
    const unsigned int first = collector.file.nodes.size();
    for (const auto &[number, position] : part.nodes) {
      collector.file.nodes.push_back(place(part, position));
      collector.file.node_numbers.push_back(number);
    }
    for (auto &[number, index] : part.node_index)
      index += first;
    for (const AbaqusElement &element : part.elements) {
      part.cells.push_back(element.nodes.empty() ? no_cell : collector.file.cells.size());
      std::vector<unsigned int> nodes;
      for (const auto node : element.nodes)
        nodes.push_back(part.node_index.at(node));
      if (!nodes.empty())
        collector.add_element(element.number, dim, element.id, nodes);
      std::vector<unsigned int> facet;
      for (const auto node : element.facet)
        facet.push_back(part.node_index.at(node));
      std::sort(facet.begin(), facet.end());
      has_facets = has_facets || !facet.empty();
      part.facets.push_back(std::move(facet));
    }
  }

  // ---- sets

  const AbaqusPart *find(const AbaqusPart &asking, const std::string &instance) const
  {
    if (instance.empty())
      return &asking;
    for (const AbaqusPart &part : parts)
      if (boost::to_upper_copy(part.name) == boost::to_upper_copy(instance))
        return &part;
    throw MeshError("the instance '" + instance + "' does not exist.");
  }

  /// The cells with these numbers; elements that are none do not count.
  std::vector<std::size_t> cells_of(const AbaqusPart &asking, const AbaqusSet &set) const
  {
    std::vector<std::size_t> cells;
    for (const auto &[instance, numbers] : set.numbers) {
      const AbaqusPart &part = *find(asking, instance);
      for (const auto number : numbers)
        if (const auto found = part.element_index.find(number); found == part.element_index.end())
          throw MeshError("the element " + std::to_string(number) + " of the set '" + set.name +
                          "' does not exist.");
        else if (part.cells[found->second] != no_cell)
          cells.push_back(part.cells[found->second]);
    }
    return cells;
  }

  /// A number or the name of a set, perhaps after "instance.".
  static AbaqusSet as_set(const AbaqusPart &part, AbaqusSets AbaqusPart::*member, const std::string &word)
  {
    if (const auto known = (part.*member).find(boost::to_upper_copy(word)); known != (part.*member).end())
      return known->second;
    if (word.empty() || word.find_first_not_of("0123456789") != std::string::npos)
      throw MeshError("the set '" + word + "' of a surface does not exist.");
    return {word, {{"", {std::stoll(word.substr(0, 18))}}}};
  }

  AbaqusSet named_set(const AbaqusPart &asking, AbaqusSets AbaqusPart::*member, const std::string &word) const
  {
    const auto dot = word.find('.');
    if (dot == std::string::npos || (asking.*member).count(boost::to_upper_copy(word)) > 0)
      return as_set(asking, member, word);
    const std::string instance = word.substr(0, dot);
    AbaqusSet set = as_set(*find(asking, instance), member, word.substr(dot + 1));
    set.numbers = {{instance, set.numbers[""]}};
    return set;
  }

  // ---- volumes

  void add_to_volume(const std::string &name, const std::vector<std::size_t> &cells)
  {
    auto &volume = collector.file.volumes[name];
    volume.insert(volume.end(), cells.begin(), cells.end());
  }

  void name_volumes(const AbaqusPart &part)
  {
    std::vector<std::size_t> all;
    for (const std::size_t cell : part.cells)
      if (cell != no_cell)
        all.push_back(cell);
    if (!part.name.empty() && !all.empty()) {
      add_to_volume(part.name, all);
      if (part.part != part.name)
        add_to_volume(part.part, all);
    }
    for (const auto &[key, set] : part.element_sets)
      if (const auto cells = cells_of(part, set); !cells.empty() && set.name[0] != '_') {
        add_to_volume(set.name, cells);
        if (!part.name.empty())
          add_to_volume(part.name + "." + set.name, cells);
      }
    for (const auto &[set, material] : part.sections) {
      const auto cells = cells_of(part, named_set(part, &AbaqusPart::element_sets, set));
      add_to_volume(material, cells);
      if (const auto dash = material.rfind('-'); dash != std::string::npos)
        if (const std::string digits = digits_in(material.substr(dash)); !digits.empty())
          for (const std::size_t cell : cells)
            collector.file.cells.ids[cell] =
                text.to_integer(digits, "an id in the name " + material, 0, largest_mesh_id);
    }
  }

  // ---- boundaries

  struct NamedFace
  {
    std::size_t cell;
    unsigned int number; ///< from 0
  };

  const std::vector<std::vector<unsigned int>> &faces_of(const std::size_t cell) const
  {
    return faces_in_abaqus.at({dim, n_vertices_in_abaqus(dim, collector.file.cells.n_nodes(cell))});
  }

  void name_faces(const AbaqusPart &part, const std::string &name, const std::vector<NamedFace> &faces,
                  const bool takes_id)
  {
    if (faces.empty())
      return;
    boundaries.push_back({name, part.name, takes_id ? digits_in(name) : "", faces});
  }

  void add_surface(const AbaqusPart &part, const AbaqusSurface &surface)
  {
    std::vector<NamedFace> faces;
    AbaqusSet nodes = {surface.name, {}};
    for (const auto &[word, face] : surface.parts) {
      if (surface.has_nodes) {
        for (const auto &[instance, numbers] : named_set(part, &AbaqusPart::node_sets, word).numbers)
          nodes.numbers[instance].insert(nodes.numbers[instance].end(), numbers.begin(), numbers.end());
        continue;
      }
      for (const std::size_t cell : cells_of(part, named_set(part, &AbaqusPart::element_sets, word))) {
        const unsigned int n_faces = faces_of(cell).size();
        if (face > n_faces)
          throw MeshError("the element " + std::to_string(collector.file.cells.numbers[cell]) +
                          " in the surface '" + surface.name + "' has no face " + std::to_string(face) + ".");
        for (unsigned int f = face == 0 ? 0 : face - 1; f < (face == 0 ? n_faces : face); ++f)
          faces.push_back({cell, f});
      }
    }
    if (surface.has_nodes)
      add_faces_of_nodes(part, nodes);
    else
      name_faces(part, surface.name, faces, true);
  }

  bool has_all_nodes(const AbaqusPart &part, const std::vector<char> &is_in) const
  {
    bool has_cells = false;
    for (const std::size_t cell : part.cells)
      if (cell != no_cell) {
        has_cells = true;
        const unsigned int *nodes = collector.file.cells.nodes_of(cell);
        if (std::any_of(nodes, nodes + collector.file.cells.n_nodes(cell),
                        [&](const unsigned int node) { return is_in[node] == 0; }))
          return false;
      }
    return has_cells;
  }

  /// The faces all vertices of which are in a set of nodes, unless it holds all nodes of a part.
  void add_faces_of_nodes(const AbaqusPart &part, const AbaqusSet &set)
  {
    std::vector<char> is_in(collector.file.nodes.size(), 0);
    for (const auto &[instance, numbers] : set.numbers) {
      const AbaqusPart &owner = *find(part, instance);
      for (const auto number : numbers)
        if (const auto found = owner.node_index.find(number); found != owner.node_index.end())
          is_in[found->second] = 1;
        else
          throw MeshError("the node " + std::to_string(number) + " of the set '" + set.name +
                          "' does not exist.");
    }
    if (set.name[0] == '_' || std::any_of(parts.begin(), parts.end(), [&](const AbaqusPart &whole) {
          return has_all_nodes(whole, is_in);
        }))
      return;
    const auto &cells = collector.file.cells;
    std::vector<NamedFace> faces;
    for (std::size_t c = 0; c < cells.size(); ++c)
      for (unsigned int f = 0; f < faces_of(c).size(); ++f)
        if (const auto &vertices = faces_of(c)[f];
            std::all_of(vertices.begin(), vertices.end(),
                        [&](const unsigned int v) { return is_in[cells.nodes_of(c)[v]] != 0; }))
          faces.push_back({c, f});
    name_faces(part, set.name, faces, false);
  }

  /// Sets of shells, or in 2D of bars, that are faces of cells; others are passed over.
  void add_facets()
  {
    if (!has_facets)
      return;
    std::map<std::vector<unsigned int>, NamedFace> face_of;
    const auto &cells = collector.file.cells;
    for (std::size_t c = 0; c < cells.size(); ++c)
      for (unsigned int f = 0; f < faces_of(c).size(); ++f) {
        std::vector<unsigned int> vertices;
        for (const unsigned int v : faces_of(c)[f])
          vertices.push_back(cells.nodes_of(c)[v]);
        std::sort(vertices.begin(), vertices.end());
        face_of.emplace(std::move(vertices), NamedFace{c, f});
      }
    for (const AbaqusPart &part : parts)
      for (const auto &[key, set] : part.element_sets) {
        std::vector<NamedFace> faces;
        for (const auto &[instance, numbers] : set.numbers) {
          const AbaqusPart &owner = *find(part, instance);
          for (const auto number : numbers)
            if (const auto found = face_of.find(owner.facets[owner.element_index.at(number)]);
                found != face_of.end())
              faces.push_back(found->second);
        }
        if (set.name[0] != '_')
          name_faces(part, set.name, faces, false);
      }
  }

  /// Ids in the names of surfaces first, then the next that are free.
  void add_faces()
  {
    std::set<std::int64_t> taken = {0};
    std::vector<std::int64_t> ids;
    for (const Boundary &boundary : boundaries) {
      const std::int64_t id =
          boundary.digits.empty()
              ? 0
              : text.to_integer(boundary.digits, "an id in the name " + boundary.name, 0, largest_mesh_id);
      ids.push_back(taken.insert(id).second ? id : 0);
    }
    std::int64_t next = 1;
    for (std::size_t b = 0; b < boundaries.size(); ++b) {
      const Boundary &boundary = boundaries[b];
      while (ids[b] == 0)
        if (taken.insert(next++).second)
          ids[b] = next - 1;
      auto &names = collector.file.boundary_names;
      names[boundary.name].push_back(ids[b]);
      if (!boundary.instance.empty())
        names[boundary.instance + "." + boundary.name].push_back(ids[b]);
      for (const NamedFace &face : boundary.faces) {
        std::vector<unsigned int> nodes;
        for (const unsigned int v : faces_of(face.cell)[face.number])
          nodes.push_back(collector.file.cells.nodes_of(face.cell)[v]);
        collector.add_element(collector.file.cells.numbers[face.cell], dim - 1, ids[b], nodes);
      }
    }
  }

  struct Boundary
  {
    std::string name, instance, digits;
    std::vector<NamedFace> faces;
  };

  MeshText &text;
  MeshCollector collector;
  const unsigned int dim;
  std::vector<AbaqusPart> parts; ///< the first is what stands outside of all
  std::vector<Boundary> boundaries;
  bool has_facets = false;
};

} // namespace

MeshFile read_abaqus(MeshText &text, const unsigned int dim)
{
  AbaqusReader reader(text, dim);
  return AbaqusAssembly(text, dim, reader).make();
}

} // namespace dovetail
