// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The grammar of `Vary`, products of its lists and names of variants.

#include <dovetail/scene/study_options.h>

#include <iostream>

using namespace dovetail;

namespace {

void show(const std::string &text)
{
  std::cout << "[" << text << "]\n";
  try {
    const auto vary = parse_vary(text);
    auto variants = product(vary);
    name_variants(vary, "scene", variants);
    for (const Variant &variant : variants) {
      std::cout << "  " << variant.name << ":";
      for (const auto &[path, value] : variant.entries)
        std::cout << " (" << path << ")=(" << value << ")";
      std::cout << '\n';
    }
  } catch (const UserError &error) {
    std::cout << "  " << error.what() << '\n';
  }
}

} // namespace

int main()
{
  show("");
  show("Interface seam/Theta : 1 | 0 | -1");
  show(" Interface  seam / Type : Nitsche|dual mortar ; Domain a/Degree , Domain b/Degree:1|2 ");
  show("A/Type : w | x ; B/Type : y | z");
  show("A/Type : x ; B/Type : y | z");
  show("Domain a/Mesh/Arguments : 2, 2 : 0, 0 : 1, 1 | 3, 3 : 0, 0 : 1, 1");
  for (const char *wrong :
       {"Theta", ": 1", "Theta : 1 |", "Theta : ", "Theta : 1 ; ", "/Theta : 1", "a, : 1",
        "Theta : 1 ; Theta : 2", "Theta : 1 | 1", "Study/Repeat : 1 | 2", "Output/Directory : a"})
    show(wrong);
}
