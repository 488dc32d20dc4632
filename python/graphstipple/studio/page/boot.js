// The page of the studio's server. In: the page's address. Out: the studio in <main>, with a socket to that server.

import { openSocket } from "./socket.js";
import { mount } from "./studio.js";

mount(document.getElementById("studio"), openSocket());
