// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

// The text of every error that the person who writes a scene can meet here.

#include <dovetail/scene/scene_text.h>

#include <algorithm>
#include <fstream>
#include <iostream>

using namespace dovetail;

namespace {

/// A small program: a scene with domains, and an interface that ties two boundaries.
void read(const std::shared_ptr<SceneText> &text)
{
  const Section scene = SceneText::root(text);
  scene.dimension();
  const std::vector<std::string> domains = scene.announce("Domains", "Domain", "Names of the bodies [-]");
  for (const std::string &name : domains) {
    const Section domain = scene.subsection("Domain " + name);
    domain.read<unsigned int>("Degree", 1, "Polynomial degree [-]");
    domain.read<double>("Scale", 1, "Factor of all coordinates [-]", Patterns::Double(1e-300));
    domain.read_point("Shift", {}, "Shift of all coordinates [m]");
    domain.read<std::vector<double>>("Lengths", {}, "Some lengths [m]");
    if (domain.has_subsection("Exact"))
      domain.subsection("Exact").require_expression("displacement", {2}, "The solution [m]");
  }
  for (const std::string &name : scene.announce("Interfaces", "Interface", "Names of the interfaces [-]")) {
    const Section seam = scene.subsection("Interface " + name);
    seam.read<std::string>("Type", "Nitsche", "The tie [-]", Patterns::Selection("Nitsche|mortar"));
    seam.read<double>("Theta", 1, "Symmetry [-]", Patterns::Double(-1, 1));
    seam.read_expression("Value", "0", {1, 4}, "Penalty [Pa/m]");
    const auto source = seam.require_boundary("Source", "Boundary of the source side [-]");
    seam.check(std::find(domains.begin(), domains.end(), source.domain) != domains.end(), "Source",
               "names the domain '" + source.domain + "', which is not among Domains (" +
                   comma_separated(domains) + "). " + did_you_mean(source.domain, domains));
  }
  text->check_all_read();
}

template <typename MakeText>
void show(const std::string &what, const MakeText &make_text)
{
  std::cout << what << ":\n  ";
  try {
    read(make_text());
    std::cout << "no error";
  } catch (const UserError &error) {
    std::cout << error.what();
  }
  std::cout << '\n';
}

void show_prm(const std::string &what, const std::string &prm)
{
  show(what, [&] { return SceneText::from_prm(prm); });
}

/// The entries @p lines stand in the interface "seam", from line 5 on.
void show_seam(const std::string &what, const std::string &lines)
{
  show_prm(what, "set Dimension = 2\nset Domains = left\nset Interfaces = seam\nsubsection Interface seam\n" +
                     lines + "\nend\nsubsection Domain left\nend\n");
}

/// The entries @p lines stand in the domain "left", from line 4 on.
void show_domain(const std::string &what, const std::string &lines)
{
  show_prm(what, "set Dimension = 2\nset Domains = left\nsubsection Domain left\n" + lines + "\nend\n");
}

void show_file(const std::string &what, const std::string &name, const std::string &content,
               const std::vector<std::string> &overrides = {})
{
  std::ofstream(name) << content;
  show(what, [&] { return SceneText::from_file(name, overrides); });
}

void grammar()
{
  show_prm("no equal sign", "set Dimension 2\n");
  show_prm("unknown keyword", "\nsubsectoin Domain left\n");
  show_prm("end missing", "subsection Domain left\nsubsection Exact\nend\nset Degree = 1\n");
  show_prm("end too many", "set Dimension = 2\nend\n");
  show_prm("entry twice", "set Dimension = 2\n# comment\nset Dimension  = 3\n");
  show_domain("entry twice in a subsection", "set Degree = 1\nset Degree = 1");
  show_prm("subsection twice", "subsection Domain left\nend\nsubsection Domain  left\nend\n");
  show_prm("forbidden letter", "subsection Domain a/b\nend\n");
}

void names()
{
  show_prm("required entry missing at the top", "set Domains = left\n");
  show_prm("dimension misspelt", "set dimension = 2\n");
  show_prm("dimension wrong", "set Dimension = 1\n");
  show_domain("entry unknown", "set degree = 1");
  show_domain("entry unknown, nothing near", "set Colour = red");
  show_domain("subsection unknown", "subsection Exakt\nend");
  show_domain("subsection unknown, nothing near", "subsection Mesh\nset File = a\nend");
  show_prm("announced without subsection",
           "set Dimension = 2\nset Domains = left\nsubsection Domain lefft\nend\n");
  show_prm("subsection not announced", "set Dimension = 2\nsubsection Domain left\nend\n");
  show_prm("plural misspelt", "set Dimension = 2\nset Domain = left\nsubsection Domain left\nend\n");
  show_prm("singular misspelt", "set Dimension = 2\nsubsection Domian left\nend\n");
  show_prm("name twice", "set Dimension = 2\nset Domains = left, left\nsubsection Domain left\nend\n");
  show_prm("name with colon", "set Dimension = 2\nset Domains = a:b\nsubsection Domain a:b\nend\n");
  show_prm("empty name", "set Dimension = 2\nset Domains = left, , right\n");
}

void values()
{
  show_domain("not a number", "set Scale = one");
  show_domain("not positive", "set Scale = 0");
  show_domain("negative degree", "set Degree = -1");
  show_domain("empty", "set Degree =");
  show_domain("list", "set Lengths = 1; 2");
  show_domain("point with one component", "set Shift = 1");
  show_domain("point with three components", "set Shift = 1; 2; 0");
  show_domain("point that leaves the plane", "set Shift = 1; 2; 3");
  show_domain("point with letters", "set Shift = 1; b");
  show_domain("expression with wrong components", "subsection Exact\nset displacement = 1; 2; 3\nend");
  show_domain("expression with unknown variable", "subsection Exact\nset displacement = x; z\nend");
  show_domain("required entry missing", "subsection Exact\nset displacment = x; y\nend");
  show_seam("out of range", "set Theta = 2");
  show_seam("not a choice", "set Type = nitsche");
  show_seam("no choice near", "set Type = glue");
  show_seam("entry unknown with this type", "set Type = mortar\nset Source = left : 1\nset Thickness = 1");
  show_seam("expression with two possible numbers", "set Value = 1; 2");
  show_seam("boundary missing", "set Theta = 0\nset Sorce = left : 1");
  show_seam("boundary empty", "set Source =");
  show_seam("boundary without ids", "set Source = left");
  show_seam("boundary with names", "set Source = left : top");
  show_seam("boundary with an id twice", "set Source = left : 1, 1");
  show_seam("reference to nothing", "set Source = left block : 1");
}

void files()
{
  show("no file", [] { return SceneText::from_file("errors_01_missing.prm", {}); });
  show_file("include of nothing", "errors_01_a.prm", "\ninclude errors_01_missing.prm\n");
  show_file("include of itself", "errors_01_a.prm", "include errors_01_a.prm\n");
  show_file("base", "errors_01_base.prm", "set Dimension = 3\n");
  show_file("included after it was set", "errors_01_a.prm",
            "set Dimension = 2\ninclude errors_01_base.prm\n");
  show_file("value of an included file", "errors_01_a.prm",
            "include errors_01_base.prm\nset Domains = left\n");
  show_file("override without equal sign", "errors_01_base.prm", "set Dimension = 3\n", {"Dimension"});
  show_file("override of nothing", "errors_01_base.prm", "set Dimension = 3\n", {"Dimensoin=2"});
  show_file("override in no subsection", "errors_01_base.prm", "set Dimension = 3\n",
            {"Output/Directory=out"});
  show_file("override in an unannounced subsection", "errors_01_base.prm", "set Dimension = 3\n",
            {"Domain left/Degree=2"});
  show_file("override with a bad value", "errors_01_base.prm", "set Dimension = 3\n", {"Dimension=4"});
}

void json()
{
  const std::string name = "errors_01.json";
  show_file("JSON grammar", name, "{\n  \"Dimension\": 2,\n  oops\n}\n");
  show_file("JSON ends early", name, "{ \"Dimension\": 2\n");
  show_file("JSON without object", name, "2");
  show_file("JSON array", name, R"({"Dimension": 2, "Domains": ["left"]})");
  show_file("JSON null", name, R"({"Dimension": null})");
  show_file("JSON key twice", name, R"({"Dimension": 2, "Domain left": {"Degree": 1, "Degree": 2}})");
  show_file("JSON unknown entry", name,
            R"({"Dimension": 2, "Domains": "left", "Domain left": {"Degre": 1}})");
  show_file("JSON wrong value", name,
            R"({"Dimension": 2, "Domains": "left", "Domain left": {"Degree": 1.5}})");
}

} // namespace

int main()
{
  grammar();
  names();
  values();
  files();
  json();
}
