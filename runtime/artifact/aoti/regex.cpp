// What include/regex declares as compiled elsewhere.
#include <regex>

template class std::basic_regex<char>;
template bool std::regex_match(const std::string&, std::smatch&, const std::regex&, std::regex_constants::match_flag_type);
