// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Messages: long values are cut, not inside a letter, and what controls a terminal is not passed on.

#include <dovetail/scene/shortened.h>

#include <iostream>

using namespace dovetail;

int main()
{
  std::cout << shortened("Degree is 'many', but must be a number.") << std::endl
            << shortened("x is '" + std::string(200, 'a') + "'.") << std::endl
            << shortened("x is '" + std::string(201, 'a') + "'. Did you mean 'b'?") << std::endl
            << shortened("x is '" + std::string(159, 'a') + "äöü" + std::string(100, 'a') + "'.") << std::endl
            << shortened("is 'a\033[31mb\r'") << std::endl
            << shortened(std::string(100000, 'a')).size() << ' ' << shortened("").size() << ' '
            << shortened("'").size() << ' ' << shortened("''").size() << std::endl;
}
