#include <algorithm>

#include "sightline/apps/common/numbers.h"
#include "sightline/apps/common/output.h"
#include "sightline/apps/view/actions.h"
#include "sightline/apps/view/needs.h"

namespace sightline::apps {

Done find_parts(const std::string& text, Session& session, Messages& messages) {
  return session.tree.find_named({text}).map([&](const std::string& words) { messages.tell(words); });
}

Done select_found(const std::string&, Session& session, Messages& messages) {
  ModelTree& tree = session.tree;
  if (!tree.named()) {
    const std::string text = tree.query().text;
    const auto words = tree.find_named(NameQuery(tree.query()));
    if (!words && !tree.find_letters()) return tl::unexpected(words.error());
    messages.tell(
        words ? *words : grouped(std::int64_t(tree.match_count())) + " parts have \"" + text + "\" in a name or value");
  }
  const std::vector<core::ItemId> items = tree.items();
  if (!messages.is_new())
    messages.tell(grouped(std::int64_t(items.size())) + (items.size() == 1 ? " item is" : " items are") +
                  " selected: " + tree.query().text);
  return session.document.select(items);
}

core::Expected<std::vector<core::ItemId>> items_named(const std::string& text, Session& session, Messages& messages) {
  auto found = session.tree.items_named(text);
  if (!found) return tl::unexpected(found.error());
  if (!found->clear) messages.tell(found->words);
  return std::move(found->items);
}

Done select_named(const std::string& text, Session& session, Messages& messages) {
  return items_named(text, session, messages).and_then([&](const std::vector<core::ItemId>& items) {
    return session.document.select(items);
  });
}

Done keep_set(const std::string& text, Session& session, Shown& shown, Messages& messages) {
  const std::string kept = text.empty() ? session.tree.query().text : text;
  if (kept.empty()) return core::fail("find something first: Ctrl+F");
  if (const auto found = session.tree.items_named(kept); !found) return tl::unexpected(found.error());
  if (shown.sets.size() == Settings::kMostSets) return core::fail("there is no room for another set: remove one first");
  std::erase(shown.sets, kept);
  shown.sets.push_back(kept);
  messages.tell("kept as a set: " + kept);
  return {};
}

Done remove_set(const std::string& text, Shown& shown) {
  if (std::erase(shown.sets, text) == 0) return core::fail("there is no set \"" + text + "\"");
  return {};
}

Done colour_by_or_ask(const std::string& key, Session& session, Shown& shown, Messages& messages) {
  if (key.empty() && session.colouring.groups.empty()) {
    shown.tab = "Attributes";
    messages.tell("choose an attribute, and Colour by this");
    return {};
  }
  return colour_by(session, key).map([&] {
    if (!key.empty()) session.attributes.choose(session.colouring.key);
  });
}

Done copy_properties(Workspace& work, const std::string&) {
  const auto selection = work.session->document.selection();
  work.window.set_clipboard(properties_table(work.session->scene(), selection, '\t'));
  work.messages.tell("copied: properties of " + grouped(std::int64_t(selection.size())) +
                     (selection.size() == 1 ? " item" : " items"));
  return {};
}

Done save_properties(const std::string& file, Session& session, Messages& messages) {
  const auto selection = session.document.selection();
  if (selection.empty()) return core::fail(needs::kSelection.missing);
  const std::string name = file.empty() ? free_name("properties", ".csv") : file;
  if (auto done = write_text(name, properties_table(session.scene(), selection, ',')); !done) return done;
  messages.tell("properties: " + name);
  return {};
}

Done toggle_part(const std::string& text, Session& session, Messages& messages) {
  Document& document = session.document;
  const PartName part = part_of(text);
  const bool numbered = text.empty() || part.node != text;  // as views have it
  const auto items = numbered ? core::Expected<std::vector<core::ItemId>>(session.items_of(part))
                              : items_named(text, session, messages);
  if (!items) return tl::unexpected(items.error());
  if (items->empty()) return core::fail("the model has no items below \"" + text + "\"");
  const auto hidden = [&](core::ItemId item) { return document.is(item, Document::kHidden); };
  return std::all_of(items->begin(), items->end(), hidden) ? document.show(*items) : document.hide(*items);
}

}  // namespace sightline::apps
