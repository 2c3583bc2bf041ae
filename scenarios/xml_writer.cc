#include "scenarios/xml_writer.h"

#include <tinyxml2.h>

#include "scenarios/text.h"

namespace lacuna {

class XmlWriter::Printer final : public tinyxml2::XMLPrinter {
 protected:
  void PrintSpace(int depth) override {
    for (int level = 0; level < depth; ++level) Write("  ");
  }
};

XmlWriter::XmlWriter() : printer_(std::make_unique<Printer>()) {}
XmlWriter::~XmlWriter() = default;

XmlWriter& XmlWriter::declare() {
  printer_->PushHeader(false, true);
  return *this;
}

XmlWriter& XmlWriter::open(const char* element) {
  printer_->OpenElement(element, on_a_line_ > 0);
  if (on_a_line_ > 0) ++on_a_line_;
  return *this;
}

XmlWriter& XmlWriter::line(const char* element) {
  open(element);
  if (on_a_line_ == 0) on_a_line_ = 1;
  return *this;
}

XmlWriter& XmlWriter::set(const char* attribute, const std::string& text) {
  printer_->PushAttribute(attribute, text.c_str());
  return *this;
}

XmlWriter& XmlWriter::set(const char* attribute, std::initializer_list<double> numbers) {
  std::string text;
  for (const double number : numbers) text.append(text.empty() ? "" : " ").append(format_number(number + 0.0));
  return set(attribute, text);
}

XmlWriter& XmlWriter::close() {
  printer_->CloseElement(on_a_line_ > 0);
  if (on_a_line_ > 0) --on_a_line_;
  return *this;
}

XmlWriter& XmlWriter::comment(std::string text) {
  for (std::size_t at = 0; (at = text.find("--", at)) != std::string::npos;) text.replace(at, 2, "- -");
  printer_->PushComment((" " + text + " ").c_str());
  return *this;
}

std::string XmlWriter::str() const { return printer_->CStr(); }

}  // namespace lacuna
