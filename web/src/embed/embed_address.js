// What the address of the bare map says: /embed/FLIGHT, with #token=... where the server asks for one and #at=... for a
// place (view_address.js).

/** @returns {{id: string, token: string, wishes: URLSearchParams}} */
export function embedded() {
  const id = decodeURIComponent(location.pathname.split('/').pop() ?? '');
  // Behind '#', so that no server or proxy on the way writes it down; before it for those who cannot.
  const wishes = new URLSearchParams(location.hash.slice(1));
  return { id, token: wishes.get('token') ?? new URLSearchParams(location.search).get('token') ?? '', wishes };
}
