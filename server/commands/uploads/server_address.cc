#include "server/commands/uploads/server_address.h"

#include "server/terminal/fail.h"

namespace skyquilt::server {

void CheckServerAddress(const char* command, std::string& url) {
  while (url.ends_with('/')) url.pop_back();
  if (url.starts_with("http://") || url.starts_with("https://")) return;
  Fail(command, {ErrorCode::kInvalidArgument,
                 url + " is no address of a server; one looks like http://127.0.0.1:8080.", ""});
}

}  // namespace skyquilt::server
