location.replace("/" + location.hash);
