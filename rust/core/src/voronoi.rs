//! voronoi
