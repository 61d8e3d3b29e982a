#include "lib/io/urdf_document.h"

#include <fmt/format.h>
#include <tinyxml2.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <span>
#include <unordered_map>
#include <unordered_set>

#include "lib/io/text.h"

namespace lanc {
namespace {

using tinyxml2::XMLElement;

struct AttributeRule {
  std::string_view name;
  int numbers = 0;  // 0: a text
  bool required = true;
};
struct ElementRule {
  std::string_view name;
  bool required = false;
  std::span<const AttributeRule> attributes = {};
  std::span<const ElementRule> children = {};
};

constexpr AttributeRule origin_attributes[] = {{"xyz", 3, false}, {"rpy", 3, false}};
constexpr AttributeRule mass_attributes[] = {{"value", 1}};
constexpr AttributeRule inertia_attributes[] = {{"ixx", 1}, {"ixy", 1}, {"ixz", 1}, {"iyy", 1}, {"iyz", 1}, {"izz", 1}};
constexpr AttributeRule axis_attributes[] = {{"xyz", 3}};
constexpr AttributeRule limit_attributes[] = {{"lower", 1, false}, {"upper", 1, false}, {"effort", 1}, {"velocity", 1}};
constexpr AttributeRule dynamics_attributes[] = {{"damping", 1, false}, {"friction", 1, false}};
constexpr AttributeRule inertial_attributes[] = {{"allow_nonphysical_inertia", 0, false}};
constexpr AttributeRule mimic_attributes[] = {{"joint"}, {"multiplier", 1, false}, {"offset", 1, false}};
constexpr AttributeRule link_reference[] = {{"link"}};
constexpr AttributeRule link_attributes[] = {{"name"}};
constexpr AttributeRule joint_attributes[] = {{"name"}, {"type"}};

constexpr ElementRule inertial_children[] = {
    {"origin", false, origin_attributes}, {"mass", true, mass_attributes}, {"inertia", true, inertia_attributes}};
constexpr ElementRule link_children[] = {{"inertial", false, inertial_attributes, inertial_children}};
constexpr ElementRule joint_children[] = {{"origin", false, origin_attributes},     {"parent", true, link_reference},
                                          {"child", true, link_reference},          {"axis", false, axis_attributes},
                                          {"dynamics", false, dynamics_attributes}, {"limit", false, limit_attributes},
                                          {"mimic", false, mimic_attributes}};
constexpr ElementRule link_rule{"link", false, link_attributes, link_children};
constexpr ElementRule joint_rule{"joint", false, joint_attributes, joint_children};

constexpr std::string_view joint_types[] = {"revolute", "continuous", "prismatic", "fixed", "floating", "planar"};

/// A finite number without regard to the locale.
bool read_number(std::string_view word, double& value) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size() && std::isfinite(value);
}

class Reader {
 public:
  Reader(const std::string& file, UrdfDocument& out) : file_(file), out_(out) {}

  void read(std::string_view text) {
    parse(text);
    const XMLElement& robot = root_element();
    const char* name = robot.Attribute("name");
    if (!name) fail(robot, "the robot has no name; write <robot name=\"...\">");
    check_name(name, place(robot), "the name of the robot");
    out_.name = name;
    printer_.OpenElement("robot");
    printer_.PushAttribute("name", name);
    for (const XMLElement* e = robot.FirstChildElement(); e; e = e->NextSiblingElement()) read_item(*e);
    printer_.CloseElement();
    out_.clean = printer_.CStr();
    check_tree(robot);
  }

 private:
  Place place(const XMLElement& e) const { return {file_, e.GetLineNum(), 0}; }
  [[noreturn]] void fail(const XMLElement& e, const std::string& what) const { throw InputError(place(e), what); }

  void parse(std::string_view text) {
    // TinyXML-2 would stop at a zero byte and call what came before it the document.
    if (const std::size_t zero = text.find('\0'); zero != text.npos) {
      const int line = 1 + static_cast<int>(std::count(text.begin(), text.begin() + zero, '\n'));
      throw InputError({file_, line, 0}, "this is not XML: a zero byte; give a URDF text file");
    }
    if (xml_.Parse(text.data(), text.size()) == tinyxml2::XML_SUCCESS) return;
    std::string reason = xml_.ErrorName();  // XML_ERROR_MISMATCHED_ELEMENT
    for (const std::string_view prefix : {"XML_ERROR_", "XML_"})
      if (reason.compare(0, prefix.size(), prefix) == 0) reason.erase(0, prefix.size());
    for (char& c : reason) c = c == '_' ? ' ' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (xml_.ErrorID() == tinyxml2::XML_ERROR_PARSING_ATTRIBUTE) reason += " (malformed, or given twice)";
    throw InputError({file_, std::max(1, xml_.ErrorLineNum()), 0},
                     fmt::format("this is not well-formed XML: {}; mend the markup", reason));
  }

  const XMLElement& root_element() const {
    const XMLElement* robot = nullptr;
    for (const tinyxml2::XMLNode* node = xml_.FirstChild(); node; node = node->NextSibling()) {
      const bool extra = node->ToText() || (node->ToElement() && robot);
      if (extra) throw InputError({file_, node->GetLineNum(), 0}, "text outside of the one <robot> element; remove it");
      if (node->ToElement()) robot = node->ToElement();
    }
    if (!robot) throw InputError({file_, 1, 0}, "there is no <robot> element; give a URDF file");
    if (robot->Name() != std::string_view("robot"))
      fail(*robot, fmt::format("the outermost element is <{}>, not <robot>; give a URDF file", shown(*robot)));
    return *robot;
  }

  static std::string shown(const XMLElement& e) {
    const std::string name = in_quotes(e.Name());
    return name.substr(1, name.size() - 2);
  }

  /// Extensions are ignored, as everybody does; but not what looks like a misspelt word of the standard.
  void ignore(const XMLElement& e, const std::string& who, std::span<const std::string_view> known) const {
    const std::string_view name = e.Name();
    if (name.substr(0, 6) == "xacro:") fail(e, fmt::format("{}: <{}> is not expanded; run xacro first", who, shown(e)));
    if (const std::string mend = did_you_mean(name, known); !mend.empty())
      fail(e, fmt::format("{}: unknown element <{}>{}", who, shown(e), mend));
  }

  void read_item(const XMLElement& e) {
    static constexpr std::string_view known[] = {"link", "joint"};
    const std::string_view kind = e.Name();
    if (kind != "link" && kind != "joint") return ignore(e, "robot", known);
    const char* given = e.Attribute("name");
    if (!given) fail(e, fmt::format("a {} has no name; add name=\"...\"", kind));
    const std::string name = given, who = fmt::format("{} {}", kind, in_quotes(name));
    check_name(name, place(e), who + ": its name");
    if (kind == "link") {
      if (!link_index_.emplace(name, static_cast<int>(out_.links.size())).second)
        fail(e, fmt::format("two links are called {}; rename one", in_quotes(name)));
      copy(e, link_rule, who);
      add_link(e, name, who);
    } else {
      if (!joint_names_.insert(name).second)
        fail(e, fmt::format("two joints are called {}; rename one", in_quotes(name)));
      check_joint(e, who);
      copy(e, joint_rule, who);
      out_.joints.push_back({name, e.FirstChildElement("parent")->Attribute("link"),
                             e.FirstChildElement("child")->Attribute("link"), place(e)});
      if (const XMLElement* mimic = e.FirstChildElement("mimic")) out_.joints.back().mimic_place = place(*mimic);
    }
  }

  void add_link(const XMLElement& e, const std::string& name, const std::string& who) {
    UrdfDocument::LinkItem link{name, place(e)};
    if (const XMLElement* inertial = e.FirstChildElement("inertial")) {
      link.has_inertia = true;
      if (const char* allow = inertial->Attribute("allow_nonphysical_inertia"); allow) {
        link.allow_nonphysical_inertia = allow == std::string_view("true");
        if (!link.allow_nonphysical_inertia && allow != std::string_view("false"))
          fail(*inertial, who + ": allow_nonphysical_inertia must be true or false");
      }
    }
    out_.links.push_back(std::move(link));
  }

  void check_joint(const XMLElement& e, const std::string& who) const {
    const char* type = e.Attribute("type");
    if (!type || std::find(std::begin(joint_types), std::end(joint_types), type) == std::end(joint_types))
      fail(e, fmt::format("{}: {}; one of {}{}", who,
                          type ? "unknown joint type " + in_quotes(type) : std::string("the type is missing"),
                          fmt::join(joint_types, ", "), type ? did_you_mean(type, joint_types) : ""));
    const bool limited = type == std::string_view("revolute") || type == std::string_view("prismatic");
    if (limited && !e.FirstChildElement("limit"))
      fail(e, fmt::format("{}: a {} joint needs <limit lower= upper= effort= velocity=>{}", who, type,
                          type == std::string_view("revolute") ? "; or make it continuous" : ""));
  }

  /// Checks an element against its rule and prints what the rule knows of it.
  void copy(const XMLElement& e, const ElementRule& rule, const std::string& who) {
    printer_.OpenElement(e.Name());
    copy_attributes(e, rule, who);
    std::vector<std::string_view> known, seen;
    for (const ElementRule& child : rule.children) known.push_back(child.name);
    for (const XMLElement* inner = e.FirstChildElement(); inner; inner = inner->NextSiblingElement()) {
      const std::string_view name = inner->Name();
      const auto child = std::find_if(rule.children.begin(), rule.children.end(),
                                      [&](const ElementRule& r) { return r.name == name; });
      if (child == rule.children.end()) {
        ignore(*inner, who, known);
        continue;
      }
      if (std::find(seen.begin(), seen.end(), name) != seen.end())
        fail(*inner, fmt::format("{}: a second <{}>; keep one", who, name));
      seen.push_back(name);
      copy(*inner, *child, fmt::format("{}: <{}>", who, name));
    }
    for (const ElementRule& child : rule.children)
      if (child.required && std::find(seen.begin(), seen.end(), child.name) == seen.end())
        fail(e, fmt::format("{}: <{}> is missing; add it", who, child.name));
    printer_.CloseElement();
  }

  void copy_attributes(const XMLElement& e, const ElementRule& rule, const std::string& who) {
    std::vector<std::string_view> known;
    for (const AttributeRule& a : rule.attributes) known.push_back(a.name);
    std::vector<std::string_view> seen;
    for (const tinyxml2::XMLAttribute* a = e.FirstAttribute(); a; a = a->Next()) {
      const std::string_view name = a->Name();
      const auto attribute = std::find_if(rule.attributes.begin(), rule.attributes.end(),
                                          [&](const AttributeRule& r) { return r.name == name; });
      if (attribute == rule.attributes.end()) {
        if (const std::string mend = did_you_mean(name, known); !mend.empty())
          fail(e, fmt::format("{}: unknown attribute {}{}", who, in_quotes(name), mend));
        continue;
      }
      if (std::find(seen.begin(), seen.end(), name) != seen.end())
        fail(e, fmt::format("{}: {} is given twice; keep one", who, name));
      seen.push_back(name);
      printer_.PushAttribute(a->Name(), attribute->numbers == 0 ? a->Value() : numbers(e, *a, *attribute, who).c_str());
    }
    for (const AttributeRule& a : rule.attributes)
      if (a.required && std::find(seen.begin(), seen.end(), a.name) == seen.end())
        fail(e, fmt::format("{}: {} is missing; add {}=\"...\"", who, a.name, a.name));
  }

  /// The numbers of an attribute, in the shortest form that reads back exactly.
  std::string numbers(const XMLElement& e, const tinyxml2::XMLAttribute& a, const AttributeRule& rule,
                      const std::string& who) const {
    constexpr std::string_view space = " \t\r\n";
    const std::string_view text = a.Value();
    std::string clean;
    int count = 0;
    for (std::size_t at = text.find_first_not_of(space); at != text.npos;) {
      const std::size_t end = std::min(text.find_first_of(space, at), text.size());
      double value = 0;
      if (!read_number(text.substr(at, end - at), value))
        fail(e, fmt::format("{}: {} of {} is not a finite number; write a plain decimal value", who,
                            in_quotes(text.substr(at, end - at)), rule.name));
      if (++count > rule.numbers) break;
      clean += fmt::format("{}{}", clean.empty() ? "" : " ", value);
      at = text.find_first_not_of(space, end);
    }
    if (count != rule.numbers)
      fail(e, fmt::format("{}: {} needs {} number{}, not {}", who, rule.name, rule.numbers,
                          rule.numbers == 1 ? "" : "s", in_quotes(text)));
    return clean;
  }

  /// One root, and at most one joint to each link. (What is then left of cycles, Model::build finds.)
  void check_tree(const XMLElement& robot) {
    if (out_.links.empty()) fail(robot, "the robot has no link; add <link name=\"...\">");
    std::vector<int> carried_by(out_.links.size(), -1);
    for (int j = 0; j < static_cast<int>(out_.joints.size()); ++j) {
      const UrdfDocument::JointItem& joint = out_.joints[j];
      const std::string who = "joint " + in_quotes(joint.name);
      for (const std::string& link : {joint.parent, joint.child})
        if (!link_index_.count(link))
          throw InputError(joint.place,
                           fmt::format("{}: there is no link {}; define it or mend the name", who, in_quotes(link)));
      int& carrier = carried_by[link_index_.at(joint.child)];
      if (carrier >= 0)
        throw InputError(joint.place,
                         fmt::format("{}: link {} already hangs on joint {}; a tree has one joint per link", who,
                                     in_quotes(joint.child), in_quotes(out_.joints[carrier].name)));
      carrier = j;
    }
    for (int i = 0; i < static_cast<int>(out_.links.size()); ++i) {
      if (carried_by[i] >= 0) continue;
      if (out_.root >= 0)
        throw InputError(out_.links[i].place,
                         fmt::format("link {} hangs on no joint, nor does {}; connect all links to one root",
                                     in_quotes(out_.links[i].name), in_quotes(out_.links[out_.root].name)));
      out_.root = i;
    }
    if (out_.root < 0)
      throw InputError(out_.joints.front().place,
                       "every link hangs on another: the joints form a cycle; a tree has none");
  }

  const std::string& file_;
  UrdfDocument& out_;
  tinyxml2::XMLDocument xml_;
  tinyxml2::XMLPrinter printer_{nullptr, true};
  std::unordered_map<std::string, int> link_index_;
  std::unordered_set<std::string> joint_names_;
};

}  // namespace

UrdfDocument read_urdf_document(std::string_view text, const std::string& file) {
  UrdfDocument document;
  Reader(file, document).read(text);
  return document;
}

}  // namespace lanc
